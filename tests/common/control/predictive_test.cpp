#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/control/control.h"

namespace lodestream::control {
namespace {

const std::vector<Level> ladder{{100'000, 0.0}, {50'000, 0.5}, {25'000, 1.0}, {12'500, 2.0}};

// 1 ms + 0.1 ms a thousand triangles and exposure + an upload of 0.03 ms a thousand: levels cost 11, 6, 3.5 and 2.25
// ms.
struct Plant {
    double slower = 1.0;
    double finest_extra_ms = 0.0;  // what level 0 costs that no linear model foresees
    double level_1_times = 1.0;    // likewise
    std::uint32_t level = 0;
    double frame_ms(const Decision& decision) const {
        const auto triangles = static_cast<double>(ladder[decision.level].triangles);
        const double times = decision.level == 1 ? level_1_times : 1.0;
        return slower * times *
                   (1.0 + decision.exposures * triangles * 1e-4 + (decision.switched ? triangles * 3e-5 : 0.0)) +
               (decision.level == 0 ? finest_extra_ms : 0.0);
    }
};

struct Session {
    Options options;
    State state;
    Measurement now;
    std::vector<Decision> decisions;
    std::vector<double> frames_ms;

    Session() {
        options.target_fps = 50.0;  // 20 ms
        options.predictive.first_guess = {1.0, 100.0, 1.0, 30.0, 1.0, 1.0, 0.0};
        now.pixels = 0.0;
    }
    void frame(const Plant& plant, double speed_deg_s) {
        now.speed_deg_s = speed_deg_s;
        Step taken = step(Kind::predictive, ladder, options, state, now);
        state = taken.state;
        decisions.push_back(taken.decision);
        now.frame_ms = plant.frame_ms(taken.decision);
        now.interval_s = std::max(now.frame_ms, 20.0) / 1000.0;
        frames_ms.push_back(now.frame_ms);
    }
    void frames(int count, const Plant& plant, double speed_deg_s) {
        for (int i = 0; i < count; ++i) frame(plant, speed_deg_s);
    }
    std::uint32_t level() const { return decisions.back().level; }
    int switches() const {
        return static_cast<int>(std::count_if(decisions.begin(), decisions.end(), [](auto& d) { return d.switched; }));
    }
    int late() const {
        return static_cast<int>(std::count_if(frames_ms.begin(), frames_ms.end(), [](double ms) { return ms > 20.0; }));
    }
};

TEST(Predictive, TakesTheFinestThatFitsFromTheFirstFrameOn) {
    Session session;
    session.frames(50, {}, 0.0);
    EXPECT_EQ(session.level(), 0u);
    EXPECT_EQ(session.switches(), 0);
    EXPECT_EQ(session.late(), 0);
}

TEST(Predictive, SaysWhatItExpects) {
    Session session;
    session.frames(50, {}, 0.0);
    EXPECT_NEAR(*session.decisions.back().predicted_ms, 11.0, 0.3);
}

TEST(Predictive, IsNotLateWhenTheViewStartsToTurn) {
    Session session;
    session.frames(50, {}, 0.0);
    session.frames(50, {}, 200.0);  // four exposures: levels cost 41, 21, 11, 6
    EXPECT_EQ(session.level(), 2u);
    EXPECT_EQ(session.late(), 0);
    EXPECT_EQ(session.switches(), 1);
}

TEST(Predictive, RefinesAfterAStopButNotAtOnce) {
    Session session;
    session.frames(50, {}, 200.0);
    const auto before = session.decisions.size();
    session.frames(50, {}, 0.0);
    EXPECT_EQ(session.decisions[before].level, 2u);
    EXPECT_EQ(session.level(), 0u);
    EXPECT_EQ(session.late(), 0);
}

// Frames of level 1 take twice what they should, those of level 0 do not: only drawing it tells.
TEST(Predictive, AtRestTriesAFinerLevelThatMayBeInTime) {
    Session session;
    Plant odd;
    odd.level_1_times = 2.0;
    session.frames(50, odd, 200.0);
    session.frames(100, odd, 0.0);
    EXPECT_EQ(session.level(), 0u);
    EXPECT_LE(session.late(), 2);
}

TEST(Predictive, AFinerLevelThatIsLateIsTriedAFewTimesAtRestAndThenNoMore) {
    Session session;
    Plant dear;
    dear.finest_extra_ms = 12.0;  // 23 ms, of which its model knows 11
    session.frames(50, dear, 200.0);
    const int switches = session.switches();
    session.frames(500, dear, 0.0);
    EXPECT_LE(session.switches() - switches, 8);  // four there and back
    EXPECT_EQ(session.level(), 1u);
    const int late = session.late();
    session.frames(3000, dear, 0.0);  // a minute
    EXPECT_EQ(session.late(), late);
    EXPECT_EQ(session.level(), 1u);
}

TEST(Predictive, CoarsensAheadOfASpeedThatGrowsWhereTheSwitchWouldNotFitThen) {
    Session session;
    session.options.predictive.first_guess.per_million_uploaded_ms = 400.0;  // 10 ms for level 2
    session.frames(50, {}, 0.0);
    // 0 → 200 degrees/s in 0.2 s; four exposures from 90 on.
    std::uint32_t exposures_at_switch = 0;
    for (int i = 1; i <= 10; ++i) {
        session.frame({}, 20.0 * i);
        if (session.decisions.back().switched && exposures_at_switch == 0)
            exposures_at_switch = session.decisions.back().exposures;
    }
    EXPECT_LT(exposures_at_switch, 4u);
    EXPECT_GT(exposures_at_switch, 0u);
}

TEST(Predictive, DoesNotChaseAViewThatPausesShorterThanTheHold) {
    Session session;
    session.frames(50, {}, 200.0);
    const int before = session.switches();
    for (int i = 0; i < 20; ++i) {
        session.frames(3, {}, 0.0);  // 0.06 s
        session.frames(5, {}, 200.0);
    }
    EXPECT_EQ(session.switches(), before);
}

TEST(Predictive, AViewThatTurnsBackIsNotTakenForOneThatStops) {
    Session session;
    session.frames(50, {}, 200.0);
    const int before = session.switches();
    for (const double speed : {150.0, 100.0, 50.0, 0.0, 50.0, 100.0, 150.0, 200.0, 200.0}) session.frame({}, speed);
    EXPECT_EQ(session.switches(), before);
}

TEST(Predictive, IsAtTheFinestAgainAFifthOfASecondAfterASuddenStop) {
    Session session;
    session.frames(50, {}, 200.0);
    EXPECT_GT(session.level(), 0u);
    session.frames(10, {}, 0.0);  // 0.2 s
    EXPECT_EQ(session.level(), 0u);
}

TEST(Predictive, FollowsADeviceThatBecomesSlower) {
    Session session;
    session.frames(50, {}, 0.0);
    session.frames(60, {2.5}, 0.0);  // 27, 15, 9, 6 ms
    EXPECT_EQ(session.level(), 1u);
    EXPECT_LE(session.late(), 12);
    session.frames(200, {1.0}, 0.0);
    EXPECT_EQ(session.level(), 0u);
}

TEST(Predictive, BetweenTheTwoSharesAViewThatTurnsKeepsItsLevel) {
    // Level 0 takes 11 ms and 3 % of safety: more than 0.86 of a deadline of 12.5 ms, less than 0.94 of it.
    Session fine, coarse;
    fine.frames(200, {}, 8.0);
    fine.options.target_fps = coarse.options.target_fps = 1000.0 / 12.5;
    fine.frames(200, {}, 8.0);
    EXPECT_EQ(fine.level(), 0u);
    coarse.frames(400, {}, 8.0);
    EXPECT_EQ(coarse.level(), 1u);
}

TEST(Predictive, AMistakenRefinementIsNotRepeatedSoon) {
    // The finest level costs 15 ms more than its triangles say: it must be tried, left, and left alone.
    Session session;
    session.frames(50, {1.0, 15.0}, 200.0);
    session.frames(1000, {1.0, 15.0}, 0.0);  // 20 s
    EXPECT_LE(session.switches(), 16);
    EXPECT_LE(session.late(), 10);
    const auto fine =
        std::count_if(session.decisions.begin(), session.decisions.end(), [](auto& d) { return d.level <= 1; });
    EXPECT_GT(fine, 900);
}

TEST(Predictive, KeepsToABudgetAndRefinesWithRoomToSpare) {
    Session session;
    session.now.budget_triangles = 60'000;
    session.frames(50, {}, 0.0);
    EXPECT_EQ(session.level(), 1u);
    session.now.budget_triangles = 105'000;  // level 0 fits, but 10 % are asked for
    session.frames(100, {}, 0.0);
    EXPECT_EQ(session.level(), 1u);
    session.now.budget_triangles = 120'000;
    session.frames(100, {}, 0.0);
    EXPECT_EQ(session.level(), 0u);
    session.now.budget_triangles = 0.0;
    session.frame({}, 0.0);
    EXPECT_EQ(session.level(), 3u);
}

TEST(Predictive, TakesTheCoarsestWhereNothingFits) {
    Session session;
    session.frames(100, {50.0}, 0.0);
    EXPECT_EQ(session.level(), 3u);
}

}  // namespace
}  // namespace lodestream::control
