// The first levels of an asset, made before its bake so that it can be served meanwhile.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "common/metric/surface_distance.h"
#include "common/texture/choice.h"
#include "proto/messages.h"
#include "server/store/store.h"

namespace lodestream::bake {

inline constexpr std::uint64_t first_level_triangles[] = {4'000, 1'000, 200};  // at most

// Makes, encodes all Gouraud and stores them, finest first; a model of no more triangles is its own first level.
// `off`: what the model, which has no instances, is off itself; `textures` are the model's. pre: the store knows the
// asset.
Result<std::vector<proto::Level>> make_first_levels(store::Store& store, const std::string& asset_id,
                                                    const mesh::Model& model, const metric::SurfaceError& off,
                                                    const texture::Textures& textures);

}  // namespace lodestream::bake
