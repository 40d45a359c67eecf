// Numbers too small for their exponent count as zero while this lives: arithmetic with them costs some processors a
// hundred times as much, and nothing that training does needs them.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace kinora::fields {

/// Holds for the thread that made it, which must destroy it. Each task of a loop has its own, so that the bits do not
/// depend on which thread runs it. Does nothing on processors other than x86.
class FlushToZero {
public:
#if defined(__SSE2__)
  FlushToZero() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040); } // results and inputs
  ~FlushToZero() { _mm_setcsr(before_); }
#else
  FlushToZero() {}
#endif
  FlushToZero(const FlushToZero&) = delete;
  FlushToZero& operator=(const FlushToZero&) = delete;

#if defined(__SSE2__)
private:
  unsigned before_;
#endif
};

} // namespace kinora::fields
