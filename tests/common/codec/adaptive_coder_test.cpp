#include "common/codec/adaptive_coder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lodestream::codec {
namespace {

struct Coded {
    std::vector<std::byte> decisions, bits;
    AdaptiveDecoder decoder() const { return {decisions, bits}; }
};

Coded finish(AdaptiveEncoder& encoder) {
    return {encoder.decisions(), encoder.whole_bits()};
}

TEST(AdaptiveCoder, DecisionsOfAnyLikelihoodComeBack) {
    for (const double share : {0.0, 0.001, 0.3, 0.5, 0.999, 1.0}) {
        std::mt19937 random(7);
        std::bernoulli_distribution yes(share);
        std::vector<bool> told;
        AdaptiveEncoder encoder;
        std::array<Decision, 3> models;
        for (std::size_t i = 0; i < 100'000; ++i) told.push_back(encoder.decide(models[i % 3], yes(random)));
        const Coded coded = finish(encoder);
        AdaptiveDecoder decoder = coded.decoder();
        models = {};
        for (std::size_t i = 0; i < told.size(); ++i) ASSERT_EQ(decoder.decide(models[i % 3]), told[i]) << i;
        EXPECT_TRUE(decoder.is_at_end());
    }
}

TEST(AdaptiveCoder, TakesAboutTheEntropy) {
    constexpr double share = 0.1, count = 200'000;
    std::mt19937 random(7);
    std::bernoulli_distribution yes(share);
    AdaptiveEncoder encoder;
    Decision model;
    for (int i = 0; i < count; ++i) encoder.decide(model, yes(random));
    const double entropy = -count * (share * std::log2(share) + (1 - share) * std::log2(1 - share)) / 8;
    const auto bytes = static_cast<double>(finish(encoder).decisions.size());
    EXPECT_GE(bytes, 0.98 * entropy);
    EXPECT_LE(bytes, 1.03 * entropy);
}

// The greatest carry there is: a low end of all ones, to which something is added.
TEST(AdaptiveCoder, CarriesRunThroughEveryWord) {
    for (int seed = 0; seed < 2000; ++seed) {
        std::mt19937 random(static_cast<unsigned>(seed));
        AdaptiveEncoder encoder;
        Decision model;
        std::vector<bool> told;
        for (int i = 0; i < 300; ++i) told.push_back(encoder.decide(model, random() % 64 == 0));
        const Coded coded = finish(encoder);
        AdaptiveDecoder decoder = coded.decoder();
        Decision again;
        for (const bool value : told) ASSERT_EQ(decoder.decide(again), value) << seed;
    }
}

TEST(AdaptiveCoder, WholeBitsOfEveryCountComeBack) {
    AdaptiveEncoder encoder;
    for (int round = 0; round < 3; ++round)
        for (int count = 0; count <= max_bits_at_once; ++count) encoder.bits(0x155'5555u & ((1u << count) - 1u), count);
    const Coded coded = finish(encoder);
    AdaptiveDecoder decoder = coded.decoder();
    for (int round = 0; round < 3; ++round)
        for (int count = 0; count <= max_bits_at_once; ++count)
            ASSERT_EQ(decoder.bits(0, count), 0x155'5555u & ((1u << count) - 1u)) << count;
    EXPECT_TRUE(decoder.is_at_end());
}

TEST(AdaptiveCoder, NumbersOfEveryLengthAndSignComeBack) {
    std::vector<std::int32_t> numbers{0};
    for (int bit = 0; bit < NumberModel::max_bits; ++bit)
        for (const std::int32_t near : {-1, 0, 1})
            for (const std::int32_t sign : {-1, 1})
                if (const std::int32_t n = sign * ((1 << bit) + near); std::abs(n) < 1 << NumberModel::max_bits)
                    numbers.push_back(n);
    AdaptiveEncoder encoder;
    NumberModel model;
    for (const std::int32_t number : numbers) EXPECT_EQ(model.code(encoder, number), number);
    const Coded coded = finish(encoder);
    AdaptiveDecoder decoder = coded.decoder();
    model = {};
    for (const std::int32_t number : numbers) ASSERT_EQ(model.code(decoder, 0), number);
    EXPECT_TRUE(decoder.is_at_end());
}

TEST(AdaptiveCoder, NothingAtAllReadsAsSomethingThatIsNotAtItsEnd) {
    AdaptiveDecoder decoder({}, {});
    NumberModel model;
    for (int i = 0; i < 10'000; ++i) model.code(decoder, 0);
    EXPECT_FALSE(decoder.is_at_end());
}

}  // namespace
}  // namespace lodestream::codec
