// Levels of a whole scene for eyes outside of it: what cannot be seen from there takes none of their triangles, and
// pieces too small to be told apart are one surface. Source: HLOD paper (seeds-digest §4), for levels of one mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "common/metric/surface_distance.h"
#include "server/bake/baked_model.h"
#include "server/bake/seen_surface.h"
#include "server/store/store.h"

namespace lodestream::bake {

inline constexpr std::size_t max_shells = 2;  // of one asset

// A baked model of what is seen from outside. `seen_errors` are of that alone, `baked.errors` of the whole scene; both
// begin with the most triangles, up to half of the scene's, at which it shows the outside better than the scene's own
// levels do: it serves budgets up to there. One of a bare surface names the triangles of the scene's finest level whose
// colours its levels get (scene_colors.h); one without has materials of its own.
template <class AnyBaked>
struct BasicShell {
    AnyBaked baked;
    std::vector<ErrorSample> seen_errors;  // finest first: triangles fall, errors do not
    std::vector<std::uint32_t> colored_by;
};
using Shell = BasicShell<BakedModel>;
using ShellView = BasicShell<BakedView>;  // its history is in the bytes that it was opened from

// The shells of a scene, those of fewer triangles first; none where the scene's own levels are always better. `scene`:
// the baked scene; `finest`: its finest level. `progress`: share done; returning false cancels. Errors: unavailable
// (cancelled), limit_exceeded (memory).
Result<std::vector<Shell>> make_shells(const BakedModel& scene, const mesh::Mesh& finest,
                                       const std::function<bool(double)>& progress);

// The shell that serves this budget, of some in that order; null where the scene's own levels do.
template <class AnyBaked>
const BasicShell<AnyBaked>* shell_for(const std::vector<BasicShell<AnyBaked>>& shells, std::uint64_t triangles) {
    for (const BasicShell<AnyBaked>& shell : shells)
        if (triangles <= shell.seen_errors.front().triangles) return &shell;
    return nullptr;
}

// A level of at most so many triangles, as simplify::cut(), with plausible normals where it has any.
template <class AnyBaked>
mesh::Mesh cut_shell(const BasicShell<AnyBaked>& shell, std::uint64_t triangles) {
    return with_plausible_normals(simplify::cut(shell.baked.history, triangles));
}

std::vector<std::byte> serialize(const Shell& shell);
// Hostile bytes, as open_baked_model().
Result<ShellView> open_shell(std::span<const std::byte> bytes);

inline std::string shell_key(std::size_t shell) {  // among an asset's content
    return "shell/" + std::to_string(shell);
}
Status put_shells(store::Store& store, const std::string& asset_id, const std::vector<Shell>& shells);

}  // namespace lodestream::bake
