#include "common/codec/adaptive_coder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lodestream::codec {
namespace {

struct Coded {
    std::vector<std::byte> symbols, bits;
    AdaptiveDecoder decoder() const { return {symbols, bits}; }
};

Coded finish(AdaptiveEncoder& encoder) {
    return {encoder.symbols(), encoder.whole_bits()};
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
    const auto bytes = static_cast<double>(finish(encoder).symbols.size());
    EXPECT_GE(bytes, 0.98 * entropy);
    EXPECT_LE(bytes, 1.03 * entropy);
}

TEST(AdaptiveCoder, SymbolsOfAnyLikelihoodComeBack) {
    for (const double share : {0.0, 0.01, 0.5, 0.99, 1.0}) {
        std::mt19937 random(7);
        std::binomial_distribution<std::size_t> any(SymbolModel::count - 1, share);
        std::vector<std::size_t> told;
        AdaptiveEncoder encoder;
        std::array<SymbolModel, 3> models;
        for (std::size_t i = 0; i < 100'000; ++i) told.push_back(encoder.symbol(models[i % 3], any(random)));
        const Coded coded = finish(encoder);
        AdaptiveDecoder decoder = coded.decoder();
        models = {};
        for (std::size_t i = 0; i < told.size(); ++i) ASSERT_EQ(decoder.symbol(models[i % 3]), told[i]) << i;
        EXPECT_TRUE(decoder.is_at_end());
    }
}

TEST(AdaptiveCoder, SymbolsTakeAboutTheirEntropy) {
    constexpr std::array<double, 4> shares{0.6, 0.25, 0.1, 0.05};
    constexpr double count = 200'000;
    std::mt19937 random(7);
    std::discrete_distribution<std::size_t> any(shares.begin(), shares.end());
    AdaptiveEncoder encoder;
    SymbolModel model;
    for (int i = 0; i < count; ++i) encoder.symbol(model, 3 * any(random));
    double entropy = 0.0;
    for (const double share : shares) entropy -= count * share * std::log2(share) / 8;
    const auto bytes = static_cast<double>(finish(encoder).symbols.size());
    EXPECT_GE(bytes, 0.98 * entropy);
    EXPECT_LE(bytes, 1.03 * entropy);
}

// However long another one was all there was.
TEST(AdaptiveCoder, NoSymbolEverLosesItsWholeShare) {
    for (std::size_t always = 0; always < SymbolModel::count; ++always) {
        SymbolModel model;
        for (int i = 0; i < 10'000; ++i) model.learn(always);
        std::uint32_t next = 0;
        for (std::size_t symbol = 0; symbol < SymbolModel::count; ++symbol) {
            const Share share = model.share(symbol);
            EXPECT_EQ(share.first, next);
            ASSERT_GE(share.size, 1u);
            for (const std::uint32_t slot : {share.first, share.first + share.size - 1})
                EXPECT_EQ(model.at(slot), symbol);
            next += share.size;
        }
        EXPECT_EQ(next, whole_probability);
    }
}

TEST(AdaptiveCoder, AModelThatKnowsWhatToExpectCostsLess) {
    const auto bytes_of = [](const NumberModel& fresh) {
        std::mt19937 random(7);
        AdaptiveEncoder encoder;
        for (int i = 0; i < 100; ++i) {
            NumberModel model = fresh;
            for (int k = 0; k < 3; ++k) model.code(encoder, static_cast<std::int32_t>(random() % 64) + 64);
        }
        return finish(encoder).symbols.size();
    };
    EXPECT_LT(bytes_of(NumberModel(7)), bytes_of(NumberModel()));
}

TEST(AdaptiveCoder, WholeBitsOfEveryCountComeBack) {
    const auto lowest = [](int count) { return static_cast<std::uint32_t>(0xd555'5555u & ((1ull << count) - 1u)); };
    AdaptiveEncoder encoder;
    for (int round = 0; round < 3; ++round)
        for (int count = 0; count <= max_bits_at_once; ++count) encoder.bits(lowest(count), count);
    const Coded coded = finish(encoder);
    AdaptiveDecoder decoder = coded.decoder();
    for (int round = 0; round < 3; ++round)
        for (int count = 0; count <= max_bits_at_once; ++count)
            ASSERT_EQ(decoder.bits(0, count), lowest(count)) << count;
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
