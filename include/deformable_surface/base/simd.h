// Wider vector instructions where the processor has them, chosen at run time: the project is built for the processor family's
// least member, so that its types fit those of the installed libraries. Without fused multiply-add the bits are the same.
#pragma once

// The sanitizers cannot run the functions that choose at start-up.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__gnu_linux__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/// Before a function of loops over plain arrays: it is compiled twice, and the right one is taken at run time.
#define DEFORMABLE_SURFACE_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define DEFORMABLE_SURFACE_WIDE
#endif
