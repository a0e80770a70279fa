// libFuzzer over lean points. The input's first part makes a cloud, which is encoded and must come back; the rest
// changes bytes of that file, its compressed streams before all, so that most of what is read is nearly right. See
// run.sh.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "tests/fuzz/input.h"

namespace {

using namespace lodestream;
using fuzz::Bytes, fuzz::require, fuzz::take;

constexpr std::uint32_t most_points = 600;  // more than two of the codec's blocks

std::uint32_t take_two(Bytes& bytes) {
    const std::uint32_t high = take(bytes);
    return high << 8 | take(bytes);
}

Vec3f vector_of(Bytes& bytes) {
    const auto next = [&] { return static_cast<std::int8_t>(take(bytes)) / 16.0f; };
    const float x = next(), y = next();
    return {x, y, next()};
}

Vec3f unit_of(const Vec3f& v) {
    const float length = glm::length(v);
    return length > 0.0f ? v / length : Vec3f{0, 1, 0};
}

// Three bytes a point as long as there are any; then those before, moved on by a little.
codec::Points cloud_of(Bytes& bytes) {
    codec::Points points;
    const std::uint32_t count = take_two(bytes) % (most_points + 1);
    const std::uint8_t kind = take(bytes);
    Bytes places = bytes.first(std::min<std::size_t>(bytes.size() / 2, std::size_t{3} * count));
    bytes = bytes.subspan(places.size());
    Box box;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3f place = places.empty() && i > 0 ? points.cloud.positions.back() + 0.01f : vector_of(places);
        points.cloud.positions.push_back(place);
        if (kind & 1) points.cloud.normals.push_back(unit_of(place));
        if (kind & 2) points.cloud.colors.emplace_back(i % 251, kind, i % 3, 255);
        box.add(Vec3d(place));
    }
    if (count > 0) points.levels = {{count, {0.0, 0.0}, kind / 64.0}};
    points.grid = codec::point_grid(box);
    return points;
}

void check_same(const codec::Points& sent, const codec::DecodedPoints& read) {
    fuzz::check(read);
    require(read.points == sent.cloud.positions.size() && read.content.cloud.positions.size() == read.points);
    require(read.content.cloud.normals.size() == sent.cloud.normals.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Bytes bytes(data, size);
    const codec::Points points = cloud_of(bytes);
    const auto glb = codec::encode_lean_points(points);
    require(glb.ok());
    const auto read = codec::decode_points(*glb);
    require(read.ok());
    check_same(points, *read);

    std::vector<std::byte> damaged = *glb;
    const bool cuts = take(bytes) % 4 == 0;
    while (bytes.size() >= 3) {
        const std::size_t from_end = take_two(bytes) % damaged.size();
        damaged[damaged.size() - 1 - from_end] ^= static_cast<std::byte>(take(bytes));
    }
    if (cuts) damaged.resize(damaged.size() - take(bytes) % damaged.size());
    if (const auto changed = codec::decode_points(damaged)) fuzz::check(*changed);
    return 0;
}
