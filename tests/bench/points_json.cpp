#include "tests/bench/points_json.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tests/bench/provenance_json.h"

namespace lodestream::bench {
namespace {

using nlohmann::json;

void add_match(json& row, const proto::SilhouetteMatch& match) {
    row["recall"] = match.recall;
    row["precision"] = match.precision;
    row["f_measure"] = match.f_measure;
}

json to_json(const proto::PointsScore& score) {
    json row{{"level", score.level},
             {"is_scaled", score.is_scaled},
             {"points", score.points},
             {"instances", score.instances},
             {"views", score.views}};
    add_match(row, score.match);
    if (score.paper_f) row["paper_f"] = *score.paper_f;
    return row;
}

json to_json(const proto::PointsSetting& setting) {
    json row{{"varied", setting.varied}, {"filter", setting.filter},         {"slices", setting.slices},
             {"side", setting.side},     {"point_size", setting.point_size}, {"points", setting.points},
             {"holes", setting.holes},   {"hole_px", setting.hole_px},       {"views", setting.views}};
    add_match(row, setting.match);
    return row;
}

json to_json(const proto::PointsCrowd& crowd) {
    json row{{"instances", crowd.instances},
             {"full_triangles", crowd.full_triangles},
             {"points", crowd.points},
             {"full_ms", crowd.full_ms},
             {"points_ms", crowd.points_ms}};
    if (crowd.paper_gain) row["paper_gain"] = *crowd.paper_gain;
    if (crowd.scaled_gain) row["scaled_gain"] = *crowd.scaled_gain;
    return row;
}

json to_json(const proto::PointsChoice& choice) {
    json row{{"device", choice.device},
             {"points_per_triangle", choice.points_per_triangle},
             {"frame_share", choice.frame_share},
             {"distance", choice.distance},
             {"triangles", choice.triangles},
             {"points", choice.points},
             {"triangles_percent", choice.triangles_percent},
             {"points_percent", choice.points_percent},
             {"chose_points", choice.chose_points}};
    if (choice.crossing) row["crossing"] = *choice.crossing;
    return row;
}

json to_json(const proto::PointsPicture& picture) {
    return {{"title", picture.title}, {"panels", picture.panels}, {"png", picture.png_base64}};
}

// Models in the order in which the run first names them.
class Models {
  public:
    template <class Row>
    void add(const char* key, const std::vector<Row>& rows) {
        for (const Row& row : rows) model(row.model)[key].push_back(to_json(row));
    }
    json& model(const std::string& name) {
        for (json& known : all)
            if (known["model"] == name) return known;
        all.push_back({{"model", name}, {"triangles", 0}});
        return all.back();
    }

    json all = json::array();
};

}  // namespace

void write_points_run(const std::string& file, const std::string& command_line, const proto::PointsRun& run) {
    Models models;
    for (const proto::PointsScore& score : run.scores) models.model(score.model)["triangles"] = score.triangles;
    models.add("scores", run.scores);
    models.add("settings", run.settings);
    models.add("crowds", run.crowds);
    models.add("choices", run.choices);
    models.add("pictures", run.pictures);
    std::ofstream out(file);
    out << json{{"run", provenance_json(command_line)}, {"models", models.all}}.dump(2) << '\n';
    if (!out.flush()) throw std::runtime_error("cannot write " + file);
}

}  // namespace lodestream::bench
