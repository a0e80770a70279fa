// From a cut level to encoded content: the split that the request asks for, held to the law that a hybrid level is
// never larger than the same level all Gouraud.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/codec/level_codec.h"
#include "common/mesh/mesh.h"
#include "common/shading/view.h"
#include "proto/messages.h"

namespace lodestream::planner {

struct SplitRequest {
    proto::ShadingMode mode = proto::ShadingMode::hybrid;
    double distance = 0.0;  // the paper's d
    shading::View view;     // world axes
};

// How a level may be encoded: each form on the grid that it needs. `lean` where it is asked for.
struct Forms {
    codec::EncodeOptions plain;
    std::optional<codec::EncodeOptions> lean;
};

struct EncodedSplit {
    codec::Encoded encoded;
    std::uint64_t gouraud = 0;
    std::uint64_t flat = 0;
    proto::ShadingMode mode = proto::ShadingMode::hybrid;  // what became of it
    bool lean = false;                                     // where it was asked for and is the smaller form
    std::uint64_t criterion_operations = 0;                // counted while the triangles were judged
};

// The JSON that a level carries in its extras, from the split's counts and mode (its `encoded` is still empty then).
using Extras = std::function<std::string(const EncodedSplit&)>;

// A level of several times the triangles, of the same surface: what the choice is measured against. Called once, and
// only where there is a choice.
using FinerLevel = std::function<mesh::Mesh()>;

// `model` gives materials, images and origin. Triangles are judged by common/shading/importance.h in the request's
// view, whatever the mode, as Table 3 counts the criterion in all of its rows; a hybrid level's against `finer`. Tries
// ever fewer and larger regions until the hybrid level is not larger than the all-Gouraud one, and sends that one if
// none is, or if a plain level's cheapest border is too dear. A lean level carries no extras, which its client has from
// the plan, and is a plain one where that is smaller.
Result<EncodedSplit> encode_split(const mesh::Model& model, const mesh::Mesh& level, const SplitRequest& request,
                                  const Forms& forms, const FinerLevel& finer, const Extras& extras);

}  // namespace lodestream::planner
