// lodestream_bench_codec: a level's bytes, picture and decoding, plain and lean, beside Draco by the defaults of
// gltf-transform's `draco` command; see README.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "client/render/renderer.h"
#include "client/report/machine.h"
#include "common/codec/glb.h"
#include "common/codec/level_codec.h"
#include "common/mesh/operations.h"
#include "common/metric/surface_distance.h"
#include "common/simplify/history.h"
#include "server/bake/bake.h"
#include "tests/bench/codec_sweep.h"
#include "tests/bench/judge.h"
#include "tests/bench/levels.h"
#include "tests/bench/peer_codecs.h"
#include "tests/bench/stopwatch.h"
#include "tests/bench/table.h"

namespace lodestream::bench {
namespace {

namespace fs = std::filesystem;

struct Arguments {
    std::vector<std::string> models;
    std::vector<std::uint64_t> counts{1000, 5000, 20000, 60000};
    std::string data = "../shared/data";
    std::string sweep_file;
    std::string command_line;  // as typed
    int turns = 15;
};

constexpr double plain_target = 0.75, lean_target = 0.6, uncompressed_target = 0.1, decode_target = 1.1;
constexpr double image_target = 1.05;
// Below it the JSON of a level is a large part of it.
constexpr std::uint64_t least_judged_triangles = 5000;
// Of the level of a sweep, or half of a smaller model.
constexpr std::uint64_t swept_triangles = 20000;

using Bytes = std::vector<std::byte>;

// What one form of a level costs and shows.
struct Form {
    std::uint64_t bytes = 0;
    double image = 0.0;  // ImageError::rms against the full model
    double encode_ms = 0.0;
    double decode_ms = 0.0;   // least of the turns
    double prepare_ms = 0.0;  // likewise, from there to the streams that the GPU is given
    // Not of a lean one: Draco's decoder alone on the same streams, and with arrays made of what it decodes.
    double draco_ms = 0.0, arrays_ms = 0.0;
    double ready_ms() const { return decode_ms + prepare_ms; }
};

struct Row {
    std::string model;
    std::uint64_t triangles = 0;
    int position_bits = 0;
    double image = 0.0;  // of the level itself
    std::uint64_t uncompressed_bytes = 0;
    Form peer, plain, lean;
};

// The Draco streams that a GLB holds.
std::vector<std::span<const std::byte>> streams_of(const codec::Glb& glb) {
    std::vector<std::span<const std::byte>> streams;
    for (const auto& primitive : glb.json.at("meshes").at(0).at("primitives")) {
        if (!primitive.contains("extensions")) continue;
        const auto& view = glb.json.at("bufferViews")
                               .at(primitive["extensions"][codec::draco_extension]["bufferView"].get<std::size_t>());
        streams.push_back(glb.binary.subspan(view.value("byteOffset", std::size_t{0}), view.at("byteLength")));
    }
    return streams;
}

class Bench {
  public:
    Bench(mesh::Model model, Painter& painter, int turns)
        : model_(std::move(model)),
          surface_(model_.mesh),
          painter_(painter),
          gallery_(painter, model_),
          history_(record_history(model_.mesh)),
          turns_(turns) {
        for (const Vec3f& p : history_.positions) bounds_.add(Vec3d(p));
    }

    std::uint64_t triangles() const { return model_.mesh.triangles.size(); }

    Row compare(const std::string& name, std::uint64_t triangles) {
        const mesh::Mesh level = simplify::cut(history_, triangles);
        Row row{name, level.triangles.size(), 0, gallery_.show(level).rms, 0, {}, {}, {}};
        const metric::SurfaceError error = metric::measure(surface_, model_.mesh, level);
        const codec::EncodeOptions options = bake::level_options(bounds_, level, error);
        row.position_bits = options.grid.bits;
        codec::Encoded plain;
        row.plain = measure(level, options, plain);
        codec::Encoded lean;
        row.lean = measure(level, bake::level_options(bounds_, level, error, true), lean);
        // Images are left out; container and JSON are ours for everyone.
        row.plain.bytes -= plain.texture_bytes;
        row.lean.bytes -= lean.texture_bytes;
        const std::uint64_t around = row.plain.bytes - plain.geometry_bytes;
        row.peer = measure_peer(level);
        row.peer.bytes += around;
        row.uncompressed_bytes = around + uncompressed_bytes(level);
        return row;
    }

    SweptModel sweep(const std::string& name, std::uint64_t triangles) {
        const mesh::Mesh level = simplify::cut(history_, triangles);
        const metric::SurfaceError error = metric::measure(surface_, model_.mesh, level);
        return {name, level.triangles.size(), sweep_codecs({model_, level, bounds_, error}, painter_, turns_)};
    }

  private:
    Form measure(const mesh::Mesh& level, const codec::EncodeOptions& options, codec::Encoded& encoded) {
        const Stopwatch watch;
        Result<codec::Encoded> made =
            codec::encode_level(model_, level, std::vector<std::uint8_t>(level.triangles.size(), 1), options);
        if (!made) throw std::runtime_error(made.error().message);
        encoded = *std::move(made);
        Form form;
        form.encode_ms = watch.elapsed().cpu_ms;
        form.bytes = encoded.glb.size();
        Result<codec::Decoded> decoded = codec::decode_level(encoded.glb);
        if (!decoded) throw std::runtime_error(decoded.error().message);
        form.image = gallery_.show(model_of(*decoded)).rms;
        const Result<codec::Glb> glb = codec::split_glb(encoded.glb);
        const Box box = render::world_bounds(*decoded);
        const auto streams = options.lean ? std::vector<std::span<const std::byte>>{} : streams_of(*glb);
        const auto keep_least = [](double& least, double ms) { least = least > 0.0 ? std::min(least, ms) : ms; };
        for (int turn = 0; turn < turns_; ++turn) {  // side by side, so that what the machine does meanwhile hits all
            keep_least(form.decode_ms, least_ms(1, [&] { (void)codec::decode_level(encoded.glb); }));
            keep_least(form.prepare_ms, least_ms(1, [&] { (void)render::prepare(*decoded, box); }));
            keep_least(form.draco_ms, draco_ms(streams, 1));
            keep_least(form.arrays_ms, draco_arrays_ms(streams, 1));
        }
        return form;
    }

    Form measure_peer(const mesh::Mesh& level) {
        const Compressed made = by_draco(level, {}, turns_);
        return {made.bytes,    gallery_.show(made.decoded).rms, made.encode_ms, made.decode_ms, 0.0, made.decode_ms,
                made.arrays_ms};
    }

    static std::uint64_t uncompressed_bytes(const mesh::Mesh& level) {
        std::uint64_t bytes = 0;
        for (const mesh::Mesh& part : by_material(level)) {
            const std::size_t vertices = part.positions.size();
            const std::size_t vertex = 12 + (part.normals.empty() ? 0 : 12) +
                                       (part.texture_coordinates.empty() ? 0 : 8) + (part.colors.empty() ? 0 : 4);
            bytes += vertices * vertex + 3 * part.triangles.size() * (vertices <= codec::max_short_vertices ? 2 : 4);
        }
        return bytes;
    }

    mesh::Model model_;
    metric::SurfaceIndex surface_;
    Painter& painter_;
    Gallery gallery_;
    simplify::History history_;
    Box bounds_;  // of all levels
    int turns_;
};

std::vector<std::string> default_models(const std::string& data) {
    std::vector<std::string> specs{"sample:teapot", "sample:terrain", "sample:ship"};
    const std::vector<std::string> files = files_below(
        data, {"classic/bunny_69k.ply", "classic/armadillo_86k.obj", "classic/nefertiti_100k.obj",
               "classic/lucy_100k.ply", "classic/buddha_100k.obj", "classic/fandisk.obj", "classic/rocker-arm.obj",
               "classic/spot_uv.obj", "scan/turbineblade_199k.ply", "terrain/stubai_10m.ply", "gltf/Duck.glb"});
    specs.insert(specs.end(), files.begin(), files.end());
    return specs;
}

double ratio(std::uint64_t a, std::uint64_t b) {
    return static_cast<double>(a) / static_cast<double>(b);
}

std::string table_of(const std::vector<Row>& rows) {
    std::vector<TableRow> table{{"model", "count",  "bits",   "peer kB", "plain",  "lean", "/ glTF",
                                 "image", "peer",   "plain/", "lean/",   "enc ms", "peer", "plain",
                                 "lean",  "dec ms", "peer",   "plain/",  "lean/",  "prep"}};
    for (const Row& r : rows)
        table.push_back({r.model,
                         std::to_string(r.triangles),
                         std::to_string(r.position_bits),
                         fixed(static_cast<double>(r.peer.bytes) / 1e3, 1),
                         fixed(ratio(r.plain.bytes, r.peer.bytes), 3),
                         fixed(ratio(r.lean.bytes, r.peer.bytes), 3),
                         fixed(ratio(r.plain.bytes, r.uncompressed_bytes), 3),
                         fixed(r.image, 3),
                         fixed(r.peer.image, 3),
                         fixed(r.plain.image / r.peer.image, 3),
                         fixed(r.lean.image / r.peer.image, 3),
                         "",
                         fixed(r.peer.encode_ms, 1),
                         fixed(r.plain.encode_ms, 1),
                         fixed(r.lean.encode_ms, 1),
                         "",
                         fixed(r.peer.decode_ms, 2),
                         fixed(r.plain.decode_ms / r.plain.draco_ms, 2),
                         fixed(r.lean.decode_ms / r.peer.decode_ms, 2),
                         fixed(r.lean.prepare_ms / r.peer.decode_ms, 2)});
    return to_text(table);
}

template <class Value>
TableRow verdict(const char* what, const std::vector<Row>& rows, double target, const Value& value) {
    double logarithms = 0, worst = 0;
    std::size_t judged = 0, met = 0;
    for (const Row& row : rows) {
        if (row.triangles < least_judged_triangles * 9 / 10) continue;
        const double ratio = value(row);
        ++judged;
        met += ratio <= target ? 1 : 0;
        logarithms += std::log(ratio);
        worst = std::max(worst, ratio);
    }
    return {what, fixed(std::exp(logarithms / static_cast<double>(judged)), 3), fixed(worst, 3), fixed(target, 2),
            std::to_string(met) + "/" + std::to_string(judged)};
}

std::string verdicts_of(const std::vector<Row>& rows) {
    return to_text({{"from 5,000 triangles on", "mean", "worst", "target", "met"},
                    verdict("bytes, plain / peer", rows, plain_target,
                            [](const Row& r) { return ratio(r.plain.bytes, r.peer.bytes); }),
                    verdict("bytes, lean / peer", rows, lean_target,
                            [](const Row& r) { return ratio(r.lean.bytes, r.peer.bytes); }),
                    verdict("bytes, plain / uncompressed glTF", rows, uncompressed_target,
                            [](const Row& r) { return ratio(r.plain.bytes, r.uncompressed_bytes); }),
                    verdict("bytes, lean / uncompressed glTF", rows, uncompressed_target,
                            [](const Row& r) { return ratio(r.lean.bytes, r.uncompressed_bytes); }),
                    verdict("picture's error, plain / peer", rows, image_target,
                            [](const Row& r) { return r.plain.image / r.peer.image; }),
                    verdict("picture's error, lean / peer", rows, image_target,
                            [](const Row& r) { return r.lean.image / r.peer.image; }),
                    verdict("decoding, plain / Draco alone", rows, decode_target,
                            [](const Row& r) { return r.plain.decode_ms / r.plain.draco_ms; }),
                    verdict("decoding, plain / Draco to arrays", rows, decode_target,
                            [](const Row& r) { return r.plain.decode_ms / r.plain.arrays_ms; }),
                    verdict("decoding, lean / peer", rows, decode_target,
                            [](const Row& r) { return r.lean.decode_ms / r.peer.decode_ms; }),
                    verdict("and preparing, plain / Draco alone", rows, decode_target,
                            [](const Row& r) { return r.plain.ready_ms() / r.plain.draco_ms; }),
                    verdict("and preparing, plain / Draco to arrays", rows, decode_target,
                            [](const Row& r) { return r.plain.ready_ms() / r.plain.arrays_ms; }),
                    verdict("and preparing, lean / peer", rows, decode_target,
                            [](const Row& r) { return r.lean.ready_ms() / r.peer.decode_ms; }),
                    verdict("decoding, plain / peer", rows, decode_target,
                            [](const Row& r) { return r.plain.decode_ms / r.peer.decode_ms; })});
}

void run(const Arguments& arguments) {
    Result<Painter> painter = Painter::create();
    if (!painter) throw std::runtime_error(painter.error().message);
    std::vector<Row> rows;
    std::vector<SweptModel> swept;
    for (const std::string& spec : arguments.models.empty() ? default_models(arguments.data) : arguments.models) {
        std::cerr << spec << std::endl;
        Bench bench(load_model(spec), *painter, arguments.turns);
        const std::string name = fs::path(spec).stem().string();
        std::uint64_t last = 0;
        for (const std::uint64_t count : arguments.counts) {
            const std::uint64_t asked = std::min(count, bench.triangles());
            if (std::exchange(last, asked) == asked) break;
            rows.push_back(bench.compare(name, asked));
        }
        if (!arguments.sweep_file.empty())
            swept.push_back(bench.sweep(name, std::min(swept_triangles, bench.triangles() / 2)));
    }
    if (!arguments.sweep_file.empty()) write_sweep(arguments.sweep_file, arguments.command_line, swept);
    std::cout << table_of(rows) << '\n' << verdicts_of(rows);
}

}  // namespace
}  // namespace lodestream::bench

int main(int argc, char** argv) {
    lodestream::bench::Arguments arguments;
    arguments.command_line = lodestream::report::joined(argc, argv);
    CLI::App app{
        "Encodes levels plain and lean beside Draco by gltf-transform's defaults: bytes, pictures and decoding."};
    app.add_option("--models", arguments.models, "model files or sample:NAME; default: samples and those of --data");
    app.add_option("--counts", arguments.counts, "triangles of the levels")->capture_default_str();
    app.add_option("--data", arguments.data, "the folder of test models")->capture_default_str();
    app.add_option("--turns", arguments.turns, "how often each is decoded; the least time counts")
        ->capture_default_str();
    app.add_option("--sweep", arguments.sweep_file,
                   "Measure every codec over its settings too, on one level of each model, and write it for "
                   "`lodestream-client report --codecs`");
    CLI11_PARSE(app, argc, argv);
    try {
        lodestream::bench::run(arguments);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "lodestream_bench_codec: " << error.what() << std::endl;
        return 1;
    }
}
