#include "server/live/transient_files.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/temporary_folder.h"

namespace lodestream::live {
namespace {

struct TransientFilesTest : ::testing::Test {
    lodestream::testing::TemporaryFolder folder;
    store::Store store = *store::Store::open(folder.path());
    std::shared_ptr<TransientFiles> files = std::make_shared<TransientFiles>(store);
    const std::string text = "some bytes";

    std::span<const std::byte> bytes() const { return std::as_bytes(std::span(text)); }
};

TEST_F(TransientFilesTest, StayWhileTheyAreKeptAndAWhileLonger) {
    auto first = files->put(bytes()), second = files->put(bytes());
    ASSERT_TRUE(first && second);
    const std::string hash = first->file.hash;
    EXPECT_EQ(second->file.hash, hash);
    const auto later = TransientFiles::Clock::now() + 2 * transient_grace;
    first->keeper.reset();
    files->sweep(later);
    EXPECT_TRUE(store.file(hash, "glb")) << "the second keeper";
    second->keeper.reset();
    files->sweep(TransientFiles::Clock::now());
    EXPECT_TRUE(store.file(hash, "glb")) << "clients have just been told of it";
    files->sweep(later);
    EXPECT_FALSE(store.file(hash, "glb"));
}

TEST_F(TransientFilesTest, WhatContentHasTooStays) {
    proto::Asset asset;
    asset.id = asset.name = "a";
    ASSERT_TRUE(store.put_asset(asset));
    ASSERT_TRUE(store.put_content("a", "k", "glb", bytes()));
    auto kept = files->put(bytes());
    ASSERT_TRUE(kept);
    const std::string hash = kept->file.hash;
    kept->keeper.reset();
    files->sweep(TransientFiles::Clock::now() + 2 * transient_grace);
    EXPECT_TRUE(store.file(hash, "glb"));
    EXPECT_TRUE(store.content("a", "k"));
}

TEST_F(TransientFilesTest, AKeeperMayOutliveAllElseButTheStore) {
    auto kept = files->put(bytes());
    ASSERT_TRUE(kept);
    files.reset();
    kept->keeper.reset();
    EXPECT_TRUE(store.file(kept->file.hash, "glb")) << "the next start sweeps it";
}

}  // namespace
}  // namespace lodestream::live
