#!/usr/bin/env python3
"""Builds the Python package alone, without ROS: pip install . (pyproject.toml names what it is)."""

import os
import pathlib
import shutil
import subprocess
import sys

import pybind11
from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

CLONE = pathlib.Path(__file__).resolve().parent
BUILD = pathlib.Path("build/pip")  # beside what scripts/build makes
MODULES = ("_core", "_render")
LOADED = ("libclothsim_bullet.so", "libclothsim_sdf.so")  # by _core, where a scene needs them
DATA = ("shaders", "config/textures", "config/fabrics")  # that pictures and fabrics need


class BuildByCMake(build_ext):
    """The modules, with the libraries in them, and what they read, into the package's folder."""

    def run(self):
        build = pathlib.Path(self.build_temp).resolve()
        package = pathlib.Path(self.get_ext_fullpath("clothsim._core")).resolve().parent
        subprocess.run(
            ["cmake", "-S", CLONE, "-B", build, "-DCLOTHSIM_ROS=OFF",
             f"-DPYTHON_EXECUTABLE={sys.executable}", f"-Dpybind11_DIR={pybind11.get_cmake_dir()}"],
            check=True)
        subprocess.run(
            ["cmake", "--build", build, "--parallel", str(os.cpu_count()), "--target",
             *("clothsim_python" + module for module in MODULES)], check=True)
        package.mkdir(parents=True, exist_ok=True)
        for module in MODULES:
            built = pathlib.Path(self.get_ext_filename(module)).name
            shutil.copy2(build / built, package / built)
        for library in LOADED:
            shutil.copy2(build / library, package)
        for folder in DATA:
            shutil.copytree(CLONE / folder, package / "share/clothsim" / folder, dirs_exist_ok=True)


os.chdir(CLONE)
BUILD.mkdir(parents=True, exist_ok=True)
setup(
    ext_modules=[Extension("clothsim." + module, []) for module in MODULES],
    cmdclass={"build_ext": BuildByCMake},
    options={"build": {"build_base": str(BUILD)}, "egg_info": {"egg_base": str(BUILD)}},
)
