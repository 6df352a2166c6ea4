#pragma once

/// Marks a kernel to be compiled for several vector units, the best chosen at run time, so that one
/// binary with the baseline ABI uses the machine's vector unit. Contraction to fused multiply-add
/// is off (-ffp-contract=off), so every clone gives the same bits.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(CLOTHSIM_NO_TARGET_CLONES)
#define CLOTHSIM_TARGET_CLONES \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define CLOTHSIM_TARGET_CLONES
#endif

/// The same for a function template, which clang cannot clone.
#ifdef __clang__
#define CLOTHSIM_TARGET_CLONES_OF_TEMPLATE
#else
#define CLOTHSIM_TARGET_CLONES_OF_TEMPLATE CLOTHSIM_TARGET_CLONES
#endif
