// A texture ladder in the store: shrunk and encoded once in the bake, read by every plan.
#pragma once

#include <cstddef>
#include <string>

#include "common/base/result.h"
#include "common/metric/surface_distance.h"
#include "common/texture/choice.h"
#include "server/store/store.h"

namespace lodestream::bake {

// Viewers of 3D Tiles show a level while its error covers at most so many pixels (their default), so that texels below
// a pixel are those shorter than the level's maximum error over this.
inline constexpr double shown_error_px = 16.0;
texture::Needs level_needs(const metric::SurfaceError& error);

Status put_textures(store::Store& store, const std::string& asset_id, const texture::Ladder& ladder);
// Of a model with `images` images. What the store does not have has no smaller sizes.
Result<texture::Ladder> load_textures(const store::Store& store, const std::string& asset_id, std::size_t images);

}  // namespace lodestream::bake
