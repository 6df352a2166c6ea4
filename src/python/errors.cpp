#include "errors.h"

#include "clothsim/model/checks.h"
#include "clothsim/model/errors.h"

namespace clothsim_python {
namespace {

PyObject* invalid_value = nullptr;
PyObject* diverged = nullptr;

PyObject* make_exception(py::module_& module, const char* name, PyObject* base, const char* doc) {
  const std::string full_name = std::string("clothsim.") + name;
  PyObject* type = PyErr_NewExceptionWithDoc(full_name.c_str(), doc, base, nullptr);
  if (type == nullptr) throw py::error_already_set();
  module.attr(name) = py::handle(type);
  return type;
}

void raise(const clothsim::InvalidValue& error) {
  std::string key;
  for (const std::string& part : error.key()) key += (key.empty() ? "" : ".") + part;
  const py::object exception = py::handle(invalid_value)(error.what());
  exception.attr("key") = key;
  PyErr_SetObject(invalid_value, exception.ptr());
}

void translate(std::exception_ptr pointer) {
  try {
    if (pointer) std::rethrow_exception(pointer);
  } catch (const clothsim::InvalidValue& error) {
    raise(error);
  } catch (const clothsim::Diverged& error) {
    PyErr_SetString(diverged, error.what());
  }
}

}  // namespace

void bind_errors(py::module_& module) {
  invalid_value = make_exception(module, "InvalidValue", PyExc_ValueError,
                                 "A value that cannot be used. The text says its key, the value "
                                 "and the values that are expected; `key` is "
                                 "the dotted path to it, such as 'cloth.ks'. Nothing has changed.");
  diverged = make_exception(module, "Diverged", PyExc_RuntimeError,
                            "A frame left the finite numbers or gained energy. The simulator still "
                            "holds the frame before.");
  py::register_exception_translator(translate);
}

std::string describe(py::handle object) {
  if (object.is_none()) return "nothing";
  constexpr std::size_t longest = 40;
  const std::string type = Py_TYPE(object.ptr())->tp_name;
  return "a value of type " + clothsim::shortened(type, longest);
}

}  // namespace clothsim_python
