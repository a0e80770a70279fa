#include "tests/bench/point_codecs.h"

#include <draco/compression/encode.h>
#include <draco/point_cloud/point_cloud_builder.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "common/base/z_order.h"
#include "common/codec/points_layout.h"

namespace lodestream::bench {
namespace {

using Steps = std::array<std::uint16_t, 4>;  // a multiple of four bytes
using Small = std::array<std::int8_t, 4>;    // likewise

struct Integers {
    std::vector<Steps> positions;
    std::vector<Small> normals;
    std::vector<Rgba8> colors;

    std::size_t size() const { return positions.size(); }
};

Integers integers_of(const points::PointCloud& cloud, int bits) {
    Box box;
    for (const Vec3f& p : cloud.positions) box.add(Vec3d(p));
    const Vec3d extent = box.extent();
    const double steps = std::exp2(bits) - 1.0, longest = std::max({extent.x, extent.y, extent.z});
    Integers all;
    all.colors = cloud.colors;
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
        Steps& p = all.positions.emplace_back();
        Small& n = all.normals.emplace_back();
        for (int k = 0; k < 3; ++k) {
            const auto axis = static_cast<std::size_t>(k);
            const double place =
                longest > 0.0 ? (static_cast<double>(cloud.positions[i][k]) - box.min[k]) / longest : 0;
            p[axis] = static_cast<std::uint16_t>(std::lround(place * steps));
            n[axis] = static_cast<std::int8_t>(std::lround(cloud.normals[i][k] * 127.0f));
        }
    }
    return all;
}

template <class Value>
void reorder(std::vector<Value>& values, const std::vector<std::size_t>& order) {
    if (values.empty()) return;
    std::vector<Value> moved;
    for (const std::size_t i : order) moved.push_back(values[i]);
    values = std::move(moved);
}

// Points from one block's end to the next along the curve. `first`: the first block's points
Integers along_curve(Integers all, std::size_t first) {
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto place = [&](std::size_t i) {
        const Steps& p = all.positions[i];
        return z_order(p[0], p[1], p[2]);
    };
    for (std::size_t begin = 0, end = first; begin < order.size(); begin = end, end *= 2)
        std::sort(order.begin() + static_cast<std::ptrdiff_t>(begin),
                  order.begin() + static_cast<std::ptrdiff_t>(std::min(end, order.size())),
                  [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
    reorder(all.positions, order);
    reorder(all.normals, order);
    reorder(all.colors, order);
    return all;
}

template <class Value>
std::uint64_t meshopt_bytes(const std::vector<Value>& values, std::size_t begin, std::size_t end) {
    if (values.empty()) return 0;
    std::vector<unsigned char> bytes(meshopt_encodeVertexBufferBound(end - begin, sizeof(Value)));
    return meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), values.data() + begin, end - begin, sizeof(Value));
}

std::uint64_t meshopt_bytes(const Integers& all, std::size_t begin, std::size_t end) {
    return meshopt_bytes(all.positions, begin, end) + meshopt_bytes(all.normals, begin, end) +
           meshopt_bytes(all.colors, begin, end);
}

std::uint64_t draco_bytes(const Integers& all, int method) {
    draco::PointCloudBuilder builder;
    builder.Start(static_cast<std::uint32_t>(all.size()));
    const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_UINT16);
    const int normal = builder.AddAttribute(draco::GeometryAttribute::GENERIC, 3, draco::DT_INT8);
    const int color =
        all.colors.empty() ? -1 : builder.AddAttribute(draco::GeometryAttribute::COLOR, 4, draco::DT_UINT8);
    for (std::uint32_t i = 0; i < all.size(); ++i) {
        builder.SetAttributeValueForPoint(position, draco::PointIndex(i), all.positions[i].data());
        builder.SetAttributeValueForPoint(normal, draco::PointIndex(i), all.normals[i].data());
        if (color >= 0) builder.SetAttributeValueForPoint(color, draco::PointIndex(i), &all.colors[i]);
    }
    const std::unique_ptr<draco::PointCloud> cloud = builder.Finalize(false);
    draco::Encoder encoder;
    constexpr int smallest = 0;
    encoder.SetSpeedOptions(smallest, smallest);
    encoder.SetEncodingMethod(method);
    draco::EncoderBuffer buffer;
    if (!encoder.EncodePointCloudToBuffer(*cloud, &buffer).ok()) throw std::runtime_error("Draco refuses the points");
    return buffer.size();
}

}  // namespace

PointSizes point_sizes(const points::PointCloud& cloud, int position_bits) {
    constexpr std::size_t first_block = 1024;
    const Integers all = integers_of(cloud, position_bits);
    const std::size_t count = all.size();
    PointSizes sizes;
    sizes.plain = count * codec::PointLayout{true, !cloud.colors.empty()}.stride();
    sizes.draco = draco_bytes(all, draco::POINT_CLOUD_KD_TREE_ENCODING);
    sizes.draco_in_order = draco_bytes(all, draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
    sizes.meshopt_in_order = meshopt_bytes(all, 0, count);
    sizes.meshopt = meshopt_bytes(along_curve(all, count), 0, count);
    const Integers blocks = along_curve(all, first_block);
    for (std::size_t begin = 0, end = first_block; begin < count; begin = end, end *= 2)
        sizes.meshopt_blocks += meshopt_bytes(blocks, begin, std::min(end, count));
    return sizes;
}

}  // namespace lodestream::bench
