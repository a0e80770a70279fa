// Where the threads of a renderer without a GPU run.
#pragma once

#include <cstddef>

namespace lodestream::render {

// Mesa's llvmpipe rasterizes with threads named llvmpipe-0, llvmpipe-1, …, as many as there are processors but at most
// 16. They sleep between frames, and the kernel then wakes two of them on one processor every other frame, which takes
// half as long again. Where there is one for each processor that this process may use, each is kept on its own: nothing
// is lost, since every frame needs them all. Returns how many were placed; 0 where there are fewer or more of them, or
// the system does not tell.
std::size_t spread_rasterizer_threads();

}  // namespace lodestream::render
