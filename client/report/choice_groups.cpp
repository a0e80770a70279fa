#include "client/report/choice_groups.h"

#include <algorithm>

namespace lodestream::report {
namespace {

ChoiceGroup& group_of(const proto::PointsChoice& choice, std::vector<ChoiceGroup>& groups) {
    const auto found = std::ranges::find_if(groups, [&](const ChoiceGroup& group) {
        return group.device == choice.device && group.points_per_triangle == choice.points_per_triangle &&
               group.frame_share == choice.frame_share;
    });
    if (found != groups.end()) return *found;
    ChoiceGroup& group = groups.emplace_back();
    group.device = choice.device;
    group.points_per_triangle = choice.points_per_triangle;
    group.frame_share = choice.frame_share;
    return group;
}

}  // namespace

bool points_are_nearer(const proto::PointsChoice& choice) {
    return choice.points_percent < choice.triangles_percent;
}

bool took_nearer(const proto::PointsChoice& choice) {
    return choice.chose_points ? choice.points_percent <= choice.triangles_percent : !points_are_nearer(choice);
}

std::vector<ChoiceGroup> choice_groups(const std::vector<proto::PointsChoice>& choices) {
    std::vector<ChoiceGroup> groups;
    for (const proto::PointsChoice& choice : choices) {
        ChoiceGroup& group = group_of(choice, groups);
        ++group.cases;
        group.points_nearer += points_are_nearer(choice);
        group.points_taken += choice.chose_points;
        group.points_found += choice.chose_points && points_are_nearer(choice);
        group.right += took_nearer(choice);
    }
    return groups;
}

ChoiceGroup sum_of(const std::vector<ChoiceGroup>& groups) {
    ChoiceGroup sum;
    for (const ChoiceGroup& group : groups) {
        sum.cases += group.cases;
        sum.points_nearer += group.points_nearer;
        sum.points_taken += group.points_taken;
        sum.points_found += group.points_found;
        sum.right += group.right;
    }
    return sum;
}

}  // namespace lodestream::report
