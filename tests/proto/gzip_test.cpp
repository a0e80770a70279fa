#include "proto/gzip.h"

#include <gtest/gtest.h>

#include <random>

namespace lodestream::proto {
namespace {

std::string noise(std::size_t size) {
    std::mt19937 random(5);
    std::string bytes(size, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    return bytes;
}

TEST(AcceptsGzip, ByNameOrStarWithAWeightAboveZero) {
    for (const char* field :
         {"gzip", "deflate, GZIP;q=0.5", "br , gzip", "*", "identity;q=0, *;q=0.1", "x-gzip", "gzip;x=y;q=1.0"})
        EXPECT_TRUE(accepts_gzip(field)) << field;
    for (const char* field : {"", "identity", "gzip;q=0", "gzip; q=0.000, *", "*;q=0", "br", "gzipped",
                              "gzip;q=", "gzip;q=x", ",,;;,", "gzip;q=-1"})
        EXPECT_FALSE(accepts_gzip(field)) << field;
}

TEST(Gzip, ComesBackWhateverPartIsDeflated) {
    const std::string bytes = std::string(5'000, 'a') + noise(200'000) + std::string(5'000, 'b');
    for (const std::size_t deflated :
         {std::size_t{0}, std::size_t{1}, std::size_t{5'000}, bytes.size() - 1, bytes.size()}) {
        const std::string packed = gzip(bytes, deflated);
        const Result<std::string> back = gunzip(packed, bytes.size());
        ASSERT_TRUE(back) << back.error().message;
        EXPECT_EQ(*back, bytes) << deflated;
    }
    EXPECT_EQ(*gunzip(gzip(""), 0), "");
    EXPECT_LT(gzip(bytes, 5'000).size(), bytes.size() - 4'500);
}

TEST(Gunzip, MoreThanAllowedIsRefusedBeforeItIsMade) {
    const std::string bomb = gzip(std::string(8'000'000, '\0'));
    const Result<std::string> back = gunzip(bomb, 1'000'000);
    ASSERT_FALSE(back);
    EXPECT_EQ(back.error().code, ErrorCode::limit_exceeded);
    EXPECT_TRUE(gunzip(gzip("abc"), 3));
    EXPECT_FALSE(gunzip(gzip("abcd"), 3));
}

TEST(Gunzip, DamagedCutOffOrPaddedIsRefused) {
    const std::string sound = gzip(noise(3'000));
    for (std::size_t size = 0; size < sound.size(); size += 7)
        EXPECT_FALSE(gunzip(std::string_view(sound).substr(0, size), 1 << 20)) << size;
    EXPECT_FALSE(gunzip(sound + "x", 1 << 20));
    std::string damaged = sound;
    damaged[sound.size() - 6] ^= 1;  // of the checksum
    EXPECT_FALSE(gunzip(damaged, 1 << 20));
    EXPECT_FALSE(gunzip("{\"plain\":true}", 1 << 20));
}

}  // namespace
}  // namespace lodestream::proto
