#pragma once

/// Marks a kernel to be compiled for several vector units, the best picked at run time, so that one
/// binary with the baseline ABI uses what the machine has. Contraction to fused multiply-add is off
/// (-ffp-contract=off), so every clone gives the same bits.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(CLOTHSIM_NO_TARGET_CLONES)
#define CLOTHSIM_TARGET_CLONES \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define CLOTHSIM_TARGET_CLONES
#endif

/// The same for a function template, of which clang makes no clones.
#ifdef __clang__
#define CLOTHSIM_TARGET_CLONES_OF_TEMPLATE
#else
#define CLOTHSIM_TARGET_CLONES_OF_TEMPLATE CLOTHSIM_TARGET_CLONES
#endif
