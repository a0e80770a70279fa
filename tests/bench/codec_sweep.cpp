#include "tests/bench/codec_sweep.h"

#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "common/codec/level_codec.h"
#include "server/bake/bake.h"
#include "tests/bench/levels.h"
#include "tests/bench/peer_codecs.h"
#include "tests/bench/provenance_json.h"
#include "tests/bench/stopwatch.h"

namespace lodestream::bench {
namespace {

using nlohmann::json;

// Of the level's own error, which the grid and the normals follow; 1 is what is served.
constexpr std::array shares_of_error{0.0, 0.25, 0.5, 1.0, 2.0, 4.0};
constexpr std::array position_bits{10, 11, 12, 14, 16};
constexpr std::array draco_speeds{0, 3, 7, 10};

// Normals need fewer bits than positions; the defaults' difference.
constexpr int fewer_normal_bits = 4;

class Sweep {
  public:
    Sweep(const SweptLevel& swept, Painter& painter, int turns)
        : swept_(swept),
          level_model_(with_mesh(swept.model, swept.level)),
          gallery_(painter, level_model_),
          turns_(turns) {}

    std::vector<CodecTrial> trials() {
        for (const bool lean : {false, true}) {
            for (const int halvings : {2, 1})
                add_ours("no error, halved " + std::to_string(halvings) + " times", options_below(halvings, lean),
                         false);
            for (const double share : shares_of_error)
                add_ours(json(share).dump() + " of the level's error", options_at(share, lean), share == 1.0);
        }
        for (const int bits : position_bits) add_draco({bits, bits - fewer_normal_bits, 12, 5});
        for (const int speed : draco_speeds) add_draco({14, 10, 12, speed});
        for (const int bits : position_bits) add_meshopt({bits, std::max(8, bits - fewer_normal_bits), 12});
        add_meshopt({});
        return std::move(trials_);
    }

  private:
    static mesh::Model with_mesh(mesh::Model model, const mesh::Mesh& level) {
        model.mesh = level;
        return model;
    }

    codec::EncodeOptions options_at(double share, bool lean) const {
        const metric::SurfaceError& error = swept_.error;
        return bake::level_options(swept_.grid_bounds, swept_.level,
                                   {share * error.rms, share * error.max, share * error.normal_degrees}, lean);
    }

    // Closer than anything that is served.
    codec::EncodeOptions options_below(int halvings, bool lean) const {
        codec::EncodeOptions options = options_at(0.0, lean);
        options.grid.bits = std::min(options.grid.bits + halvings, codec::max_position_bits);
        options.normal_tolerance_degrees = std::ldexp(options.normal_tolerance_degrees, -halvings);
        options.normal_bits = codec::fit_normal_bits(options.normal_tolerance_degrees);
        return options;
    }

    void add_ours(const std::string& setting, const codec::EncodeOptions& options, bool is_default) {
        const std::vector<std::uint8_t> all_gouraud(swept_.level.triangles.size(), 1);
        const Stopwatch watch;
        Result<codec::Encoded> encoded = codec::encode_level(swept_.model, swept_.level, all_gouraud, options);
        if (!encoded) throw std::runtime_error(encoded.error().message);
        CodecTrial trial;
        trial.encode_ms = watch.elapsed().cpu_ms;
        trial.codec = options.lean ? "lean" : "plain";
        trial.setting = setting + ", " + std::to_string(options.grid.bits) + " bits";
        trial.is_default = is_default;
        trial.bytes = encoded->geometry_bytes;
        const Result<codec::Decoded> decoded = codec::decode_level(encoded->glb);
        if (!decoded) throw std::runtime_error(decoded.error().message);
        trial.image_rms = gallery_.show(model_of(*decoded)).rms;
        trial.decode_ms = least_ms(turns_, [&] { (void)codec::decode_level(encoded->glb); });
        trials_.push_back(std::move(trial));
    }

    void add_draco(const DracoSettings& s) {
        const DracoSettings usual;
        const bool is_default = s.position_bits == usual.position_bits && s.speed == usual.speed;
        add("draco", std::to_string(s.position_bits) + " bits, speed " + std::to_string(s.speed), is_default,
            by_draco(swept_.level, s, turns_));
    }

    void add_meshopt(const MeshoptSettings& s) {
        const MeshoptSettings usual;
        const bool is_default = s.position_bits == usual.position_bits && s.normal_bits == usual.normal_bits;
        add("meshopt", std::to_string(s.position_bits) + " bits, normals " + std::to_string(s.normal_bits), is_default,
            by_meshopt(swept_.level, s, turns_));
    }

    void add(const char* codec, std::string setting, bool is_default, const Compressed& made) {
        trials_.push_back({codec, std::move(setting), is_default, made.bytes, made.encode_ms, made.decode_ms,
                           gallery_.show(made.decoded).rms});
    }

    SweptLevel swept_;
    mesh::Model level_model_;
    Gallery gallery_;
    int turns_;
    std::vector<CodecTrial> trials_;
};

json to_json(const CodecTrial& t) {
    return {{"codec", t.codec},         {"setting", t.setting},     {"is_default", t.is_default}, {"bytes", t.bytes},
            {"encode_ms", t.encode_ms}, {"decode_ms", t.decode_ms}, {"image_rms", t.image_rms}};
}

}  // namespace

std::vector<CodecTrial> sweep_codecs(const SweptLevel& swept, Painter& painter, int turns) {
    return Sweep(swept, painter, turns).trials();
}

void write_sweep(const std::string& file, const std::string& command_line, const std::vector<SweptModel>& models) {
    json j{{"run", provenance_json(command_line)}, {"models", json::array()}};
    for (const SweptModel& model : models) {
        json trials = json::array();
        for (const CodecTrial& trial : model.trials) trials.push_back(to_json(trial));
        j["models"].push_back({{"model", model.model}, {"triangles", model.triangles}, {"trials", trials}});
    }
    std::ofstream out(file);
    out << j.dump(2) << '\n';
    if (!out) throw std::runtime_error("cannot write " + file);
}

}  // namespace lodestream::bench
