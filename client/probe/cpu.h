// The processor's speed at arithmetic that neither memory nor vector units decide.
#pragma once

#include <cstdint>

#include "client/probe/statistics.h"

namespace lodestream::probe {

// One operation is a step of a 64-bit hash followed by a multiplication and addition in double precision. `threads`
// work at once for `seconds`, and for a few rounds at least; the rate is that of all threads together. A thread's time
// is the time that it was running, so that other processes do not make the processor look slow. pre: threads >= 1
Rate measure_cpu(std::uint32_t threads, double seconds);

}  // namespace lodestream::probe
