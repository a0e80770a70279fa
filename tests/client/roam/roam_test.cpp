#include "client/roam/roam.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <optional>

#include <cmath>
#include <limits>

#include "client/roam/http_tiles.h"
#include "client/roam/slow_link.h"
#include "tests/client/render/with_renderer.h"
#include "tests/client/roam/plates.h"

namespace lodestream::roam {
namespace {

using ::testing::ElementsAre;
using testing::FakeTiles;
using ::testing::HasSubstr;
using testing::plates;

class RoamTest : public lodestream::testing::WithRenderer {
  protected:
    RoamTest() {
        options.width = 64;
        options.height = 48;
        options.samples = 1;
        options.fade_s = 0.2;
        options.stream.max_bytes = 1u << 20;
        home.eye = {0.0, 1.0, 0.01};
        home.target = {0.0, 0.0, 0.0};
    }

    Roamed roam_through(Tiles& tiles, const motion::Trace& motion) {
        auto roamed = roam(*renderer, tileset, tiles, motion, home, options);
        EXPECT_TRUE(roamed) << roamed.error().message;
        return roamed ? *std::move(roamed) : Roamed{};
    }

    // Down onto the plates, along them and up again, always within them.
    motion::Trace flight() const {
        motion::Trace trace;
        for (int i = 0; i <= 120; ++i) {
            const double u = i / 120.0;
            trace.push_back({4.0 * u, {Vec3d{6.0 * u - 3.0, 0.3 + 2.0 * std::abs(2.0 * u - 1.0), 0.0}, 0.0, -80.0}});
        }
        return trace;
    }

    proto::Tileset tileset = plates(5);
    RoamOptions options;
    shading::View home;
};

std::size_t background_pixels(const render::Image& image) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) count += image.rgba[i + 1] == 255 ? 1 : 0;
    return count;
}

TEST_F(RoamTest, NoPixelIsEverAHoleAndTheMemoryHoldsWhateverCome) {
    for (const std::uint64_t max_bytes : {40'000u, 200'000u}) {
        FakeTiles tiles(tileset);
        tiles.delay = 0.7;
        options.stream.max_bytes = max_bytes;
        options.stream.max_requests = 5;
        std::size_t frame = 0, holes = 0, blank = 0;
        options.on_frame = [&](const render::Image& image) -> Status {
            const std::size_t here = background_pixels(image);
            if (here == image.pixels() && frame == blank)
                ++blank;  // until the root is here
            else
                holes += here;
            ++frame;
            return Nothing{};
        };
        const Roamed roamed = roam_through(tiles, flight());
        EXPECT_EQ(holes, 0u);
        EXPECT_LT(blank, 60u);
        EXPECT_EQ(roamed.frames.size(), 121u);
        EXPECT_LE(tiles.largest_request, 5u);
        std::size_t fading = 0, finest = 0;
        for (const RoamFrame& now : roamed.frames) {
            EXPECT_LE(now.gpu_bytes, max_bytes);
            EXPECT_TRUE(std::isfinite(now.error_px) && std::isfinite(now.missed_px));
            fading += now.fading_tiles;
            finest = std::max(finest, now.tiles);
        }
        EXPECT_GT(fading, 100u);
        EXPECT_GT(finest, 10u);
    }
}

TEST_F(RoamTest, ATileThatCannotBeDecodedIsCoveredByItsParentAndReportedOnce) {
    FakeTiles tiles(tileset);
    tiles.failing.emplace(2, invalid_input("/2: no GLB"));
    std::size_t holes = 0, frame = 0;
    options.on_frame = [&](const render::Image& image) -> Status {
        if (frame++ > 1) holes += background_pixels(image);
        return Nothing{};
    };
    const Roamed roamed = roam_through(tiles, {{0.0, {}}, {2.0, {}}});
    EXPECT_THAT(roamed.failures, ElementsAre(HasSubstr("no GLB")));
    EXPECT_EQ(tiles.asked[2], 1);
    EXPECT_EQ(holes, 0u);
    EXPECT_EQ(roamed.frames.back().tiles, 1u) << "the root, whose child it is";
    EXPECT_EQ(roamed.frames.back().missing_tiles, 0u);
    EXPECT_GT(roamed.frames.back().missed_px, 0.0);
}

TEST_F(RoamTest, TilesLargerThanTheirBytesLetExpectKeepToTheMemoryAllTheSame) {
    FakeTiles tiles(tileset);
    tileset.bytes.assign(tileset.bytes.size(), 1);
    options.stream.max_bytes = 4'000;
    options.stream.tolerance_px = 0.0;
    const Roamed roamed = roam_through(tiles, {{0.0, {}}, {3.0, {}}});
    for (const RoamFrame& frame : roamed.frames) EXPECT_LE(frame.gpu_bytes, 4'000u);
    EXPECT_GT(roamed.frames.back().tiles, 4u);
    EXPECT_GT(roamed.frames.back().missed_px, 0.0);
    for (const auto& [node, times] : tiles.asked) EXPECT_LE(times, 2) << "node " << node << " is fetched in vain";
}

TEST_F(RoamTest, WhatTheNetworkFailsToBringIsAskedForAgainSomeTimes) {
    FakeTiles tiles(tileset);
    tiles.failing.emplace(3, fail(ErrorCode::io, "/3: timed out"));
    const Roamed roamed = roam_through(tiles, {{0.0, {}}, {2.0, {}}});
    EXPECT_EQ(tiles.asked[3], max_attempts);
    EXPECT_THAT(roamed.failures, ElementsAre(HasSubstr("timed out")));
}

// What a server tells of a tileset in documents, and a client that has read some of them.
class Documents {
  public:
    explicit Documents(proto::Tileset whole) : whole_(std::move(whole)) {
        proto::split_into_documents(whole_,
                                    [](std::uint64_t id, std::uint64_t) { return std::to_string(id) + ".json"; });
        now = *proto::parse_tileset(proto::to_json(whole_));
    }
    void open(const std::string& document) {
        const auto node =
            static_cast<std::uint32_t>(std::ranges::find(now.documents, document) - now.documents.begin());
        ASSERT_LT(node, now.nodes.size()) << document;
        const std::string json = proto::to_json(whole_, static_cast<std::uint32_t>(std::stoul(document)));
        ASSERT_TRUE(proto::add_document(now, node, *proto::parse_document(json, now.matrix(node))).ok());
        ++opened;
    }

    proto::Tileset now;
    int opened = 0;

  private:
    proto::Tileset whole_;
};

TEST_F(RoamTest, DocumentsAreOpenedWhereTheViewRefinesAndNothingIsAHoleMeanwhile) {
    Documents documents(plates(7));
    tileset = documents.now;
    const std::size_t named =
        tileset.documents.size() - static_cast<std::size_t>(std::ranges::count(tileset.documents, ""));
    ASSERT_EQ(named, 16u);  // of 341 tiles each
    FakeTiles tiles(tileset);
    tiles.delay = 0.5;
    options.stream.max_bytes = 16u << 20;
    options.stream.max_requests = 64;
    std::vector<std::string> asked;
    options.open = [&](const std::vector<std::string>& wanted) { asked = wanted; };
    options.newer = [&]() -> std::optional<proto::Tileset> {
        if (asked.empty()) return std::nullopt;
        documents.open(asked.front());
        asked.clear();
        return documents.now;
    };
    std::size_t holes = 0;
    bool has_begun = false;
    options.on_frame = [&](const render::Image& image) -> Status {
        const std::size_t here = background_pixels(image);
        has_begun = has_begun || here < image.pixels();
        holes += has_begun ? here : 0;
        return Nothing{};
    };
    const motion::Trace still{{0.0, {Vec3d{-20.0, 1.0, -20.0}, 0.0, -80.0}},
                              {4.0, {Vec3d{-20.0, 1.0, -20.0}, 0.0, -80.0}}};
    const Roamed roamed = roam_through(tiles, still);
    EXPECT_EQ(holes, 0u);
    EXPECT_GT(documents.opened, 0);
    EXPECT_LT(documents.opened, 16) << "only where the view is";
    EXPECT_EQ(roamed.revisions, static_cast<std::uint64_t>(documents.opened));
    const RoamFrame& last = roamed.frames.back();
    EXPECT_EQ(last.missing_tiles, 0u);
    EXPECT_LE(last.error_px, options.stream.tolerance_px);
    EXPECT_TRUE(has_begun);
}

TEST_F(RoamTest, WithoutItsRootASceneIsAnError) {
    FakeTiles tiles(tileset);
    tiles.failing.emplace(0, invalid_input("/0: no GLB"));
    const auto roamed = roam(*renderer, tileset, tiles, {{0.0, {}}, {1.0, {}}}, home, options);
    ASSERT_FALSE(roamed);
    EXPECT_THAT(roamed.error().message, HasSubstr("no GLB"));
}

TEST_F(RoamTest, MovingOverLevelsThatDoNotChangeIsNoPopping) {
    FakeTiles tiles(tileset);
    options.stream.tolerance_px = 0.0;  // everything at its finest, wherever the camera is
    const Roamed roamed = roam_through(tiles, flight());
    std::size_t changed = 0;
    for (const RoamFrame& frame : roamed.frames) {
        if (frame.t_s < 2.0) continue;
        changed += frame.has_changed ? 1 : 0;
        EXPECT_EQ(frame.popping.largest, 0.0);
    }
    EXPECT_EQ(changed, 0u);
    EXPECT_GT(summarize(roamed).popping_largest, 0.0) << "while the levels came";
}

TEST_F(RoamTest, FadingSpreadsAChangeOverItsFrames) {
    options.samples = 4;
    options.fps = 60.0;
    options.fade_s = 0.5;
    FakeTiles slowly(tileset), at_once(tileset);
    const RoamSummary fading = summarize(roam_through(slowly, flight()));
    options.fade_s = 0.0;
    const RoamSummary popping = summarize(roam_through(at_once, flight()));
    EXPECT_LT(fading.popping_largest, 0.8 * popping.popping_largest);
    EXPECT_LT(fading.popping_rms, 0.4 * popping.popping_rms);
    EXPECT_GT(fading.changes, 4 * popping.changes);
}

TEST_F(RoamTest, LookingAheadAlongTheMotionMissesLessOverASlowLink) {
    tileset = plates(7);
    options.fps = 30.0;
    const auto missed_px = [&](bool looks_ahead) {
        options.looks_ahead = looks_ahead;
        FakeTiles tiles(tileset);
        SlowLink link(tiles, {.downlink_mbps = 0.0, .rtt_ms = 200.0});
        motion::Trace motion;
        for (int i = 0; i <= 300; ++i) motion.push_back({0.02 * i, {Vec3d{0.04 * i - 6.0, 0.8, 0.0}, -90.0, -60.0}});
        double missed = 0.0;
        for (const RoamFrame& frame : roam_through(link, motion).frames)
            missed += frame.t_s > 3.0 ? frame.missed_px : 0;
        return missed;
    };
    const double without = missed_px(false);
    EXPECT_GT(without, 0.0);
    EXPECT_LT(missed_px(true), 0.7 * without);
}

TEST_F(RoamTest, ADeepTreeIsThereAfterOneRoundTripNotOneForEachLevel) {
    tileset = plates(3);
    options.fps = 20.0;
    options.fade_s = 0.0;
    options.stream.tolerance_px = 0.0;
    options.stream.max_requests = connections;
    FakeTiles tiles(tileset);
    SlowLink link(tiles, {.downlink_mbps = 0.0, .rtt_ms = 1000.0});
    const Roamed roamed = roam_through(link, {{0.0, {}}, {2.0, {}}});
    EXPECT_EQ(roamed.frames[19].tiles, 0u);
    EXPECT_EQ(roamed.frames[20].tiles, 4u) << "the root, its children and one of theirs came together";
    EXPECT_EQ(roamed.frames[20].missing_tiles, roamed.frames[0].missing_tiles - connections);
}

TEST_F(RoamTest, KeepsToTheClockThatItIsGiven) {
    FakeTiles tiles(tileset);
    std::vector<double> times;
    options.fps = 10.0;
    options.wait_until = [&](double t_s) { times.push_back(t_s); };
    roam_through(tiles, {{5.0, {}}, {5.25, {}}});
    EXPECT_THAT(times, ElementsAre(0.0, 0.1, 0.2));
}

TEST_F(RoamTest, TilesOfPointsThatAreMovedAreRefused) {
    FakeTiles tiles(tileset);
    tileset.is_additive = true;
    tileset.matrices.assign(tileset.nodes.size(), Mat4d(2.0));
    const auto refused = roam(*renderer, tileset, tiles, {{0.0, {}}}, home, options);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
}

TEST_F(RoamTest, WrongNumbersAreRefused) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    FakeTiles tiles(tileset);
    const RoamOptions sound = options;
    const auto is_refused = [&](const motion::Trace& motion) {
        return !roam(*renderer, tileset, tiles, motion, home, options);
    };
    const motion::Trace still{{0.0, {}}, {1.0, {}}};
    for (const double fps : {0.0, none, 1e9}) {
        options.fps = fps;
        EXPECT_TRUE(is_refused(still)) << fps;
    }
    options = sound;
    for (const double fade_s : {-1.0, none, std::numeric_limits<double>::infinity()}) {
        options.fade_s = fade_s;
        EXPECT_TRUE(is_refused(still)) << fade_s;
    }
    options = sound;
    options.stream.tolerance_px = none;
    EXPECT_TRUE(is_refused(still));
    options = sound;
    options.width = 0;
    EXPECT_TRUE(is_refused(still));
    options = sound;
    EXPECT_TRUE(is_refused({}));
    EXPECT_TRUE(is_refused({{0.0, {}}, {1e9, {}}})) << "too many frames";
    options.on_frame = [](const render::Image&) -> Status { return fail(ErrorCode::io, "full"); };
    EXPECT_TRUE(is_refused(still));
}

// While the camera flies, one tile after the other shows something else, or the tree grows by what has been split.
TEST_F(RoamTest, WhenTheSceneChangesOnlyWhatHasChangedIsFetchedAndNothingIsAHole) {
    FakeTiles tiles(tileset);
    tiles.delay = 0.3;
    options.stream.tolerance_px = 8.0;
    tileset.ids.resize(tileset.nodes.size());
    std::iota(tileset.ids.begin(), tileset.ids.end(), 0u);
    proto::Tileset now = tileset;
    std::size_t frame = 0, holes = 0, blank = 0;
    options.newer = [&]() -> std::optional<proto::Tileset> {
        if (frame % 20 != 19) return std::nullopt;
        now.uris[frame % 5] += "'";
        ++now.revision;
        return now;
    };
    options.on_frame = [&](const render::Image& image) -> Status {
        const std::size_t here = background_pixels(image);
        blank += here == image.pixels() && frame == blank ? 1 : 0;
        holes += frame >= blank ? here : 0;
        ++frame;
        return Nothing{};
    };
    const Roamed changing = roam_through(tiles, flight());
    EXPECT_EQ(holes, 0u);
    EXPECT_EQ(changing.revisions, 6u);
    EXPECT_EQ(changing.frames.back().outdated_tiles, 0u);
    EXPECT_GT(tiles.asked[4], 1) << "its content has changed";
    for (const auto& [node, times] : tiles.asked)
        EXPECT_TRUE(node <= 4 || times <= 3) << node << ": what waits when a revision comes is asked for anew, no more";
}

TEST_F(RoamTest, WhatIsOutdatedIsShownUntilItsNewContentIsHere) {
    FakeTiles tiles(tileset);
    options.stream.tolerance_px = 1e6;  // the root alone
    tileset.ids.resize(tileset.nodes.size());
    std::iota(tileset.ids.begin(), tileset.ids.end(), 0u);
    std::size_t frame = 0;
    options.newer = [&]() -> std::optional<proto::Tileset> {
        if (frame++ != 10) return std::nullopt;
        proto::Tileset now = tileset;
        now.uris[0] = "/new";
        tiles.delay = 1.0;
        return now;
    };
    std::size_t pictures = 0;
    options.on_frame = [&](const render::Image& image) -> Status {
        EXPECT_TRUE(++pictures < 3 || background_pixels(image) == 0) << pictures;
        if (pictures == 20) tiles.delay = 0.0;
        return Nothing{};
    };
    const Roamed roamed = roam_through(tiles, {{0.0, {}}, {1.0, {}}});
    EXPECT_EQ(roamed.frames[9].outdated_tiles, 0u);
    EXPECT_EQ(roamed.frames[15].outdated_tiles, 1u);
    EXPECT_EQ(roamed.frames.back().outdated_tiles, 0u);
    EXPECT_EQ(tiles.asked[0], 2);
}

// Tiles come and go with a revision: a node that is no longer there, and children where there were none.
TEST_F(RoamTest, TilesThatAreGoneLeaveTheGpuAndNewOnesCome) {
    FakeTiles tiles(tileset);
    options.stream.tolerance_px = 0.0;
    proto::Tileset smaller = tileset;
    smaller.nodes.resize(5);
    smaller.uris.resize(5);
    smaller.bytes.resize(5);
    for (std::size_t i = 1; i < 5; ++i) smaller.nodes[i].first_child = smaller.nodes[i].child_count = 0;
    for (const bool grows : {false, true}) {
        proto::Tileset first = grows ? smaller : tileset, second = grows ? tileset : smaller;
        std::size_t frame = 0;
        options.newer = [&]() -> std::optional<proto::Tileset> {
            return frame++ == 15 ? std::optional(second) : std::nullopt;
        };
        std::size_t pictures = 0, holes = 0;
        options.on_frame = [&](const render::Image& image) -> Status {
            holes += ++pictures > 3 ? background_pixels(image) : 0;
            return Nothing{};
        };
        auto roamed = roam(*renderer, first, tiles, {{0.0, {}}, {2.0, {}}}, home, options);
        ASSERT_TRUE(roamed) << roamed.error().message;
        EXPECT_EQ(holes, 0u);
        EXPECT_EQ(roamed->frames[14].tiles > 4, !grows);
        EXPECT_EQ(roamed->frames.back().tiles > 4, grows);
        if (!grows) {
            EXPECT_LT(roamed->frames.back().gpu_bytes, roamed->frames[14].gpu_bytes);
        }
    }
}

}  // namespace
}  // namespace lodestream::roam
