// Functions that are compiled for several kinds of processors.

#pragma once

#include <cstddef>  // tells which C library it is

// Where the linker can choose among several versions of a function by the processor that it finds (the GNU C library
// can), there is one for each width of vectors. A sanitizer must not run before it is set up, as a choice does.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__SANITIZE_ADDRESS__)
#define HOLDFAST_WIDE __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define HOLDFAST_WIDE
#endif
