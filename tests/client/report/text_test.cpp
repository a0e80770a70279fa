#include "client/report/text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace lodestream::report {
namespace {

TEST(Text, TerminalEscapesAndLineBreaksCannotReachTheTerminal) {
    EXPECT_EQ(printable("a\x1b[2Jb\nc"), "a\uFFFD[2Jb\uFFFDc");
    EXPECT_EQ(printable("\xC2\x9B"), "\uFFFD");        // C1 control sequence introducer
    EXPECT_EQ(printable("x\u202Ecod"), "x\uFFFDcod");  // right-to-left override
}

TEST(Text, BytesThatAreNotUtf8AreReplaced) {
    EXPECT_EQ(printable("\xFF"), "\uFFFD");
    EXPECT_EQ(printable("a\xC3"), "a\uFFFD");                              // cut off
    EXPECT_EQ(printable("\xC0\x80"), "\uFFFD\uFFFD");                      // overlong
    EXPECT_EQ(printable("\xED\xA0\x80"), "\uFFFD\uFFFD\uFFFD");            // surrogate
    EXPECT_EQ(printable("\xF4\x90\x80\x80"), "\uFFFD\uFFFD\uFFFD\uFFFD");  // beyond Unicode
    EXPECT_EQ(printable("찻주전자 – 🫖"), "찻주전자 – 🫖");
}

TEST(Text, MarkupIsEscapedInTextAndAttributes) {
    EXPECT_EQ(escape_html("<script>\"a\" & 'b'</script>"),
              "&lt;script&gt;&quot;a&quot; &amp; &#39;b&#39;&lt;/script&gt;");
}

TEST(Text, FileStemsCannotLeaveTheirFolderOrHide) {
    EXPECT_EQ(file_stem("../../etc/passwd"), "_._.._etc_passwd");
    EXPECT_EQ(file_stem(".hidden"), "_hidden");
    EXPECT_EQ(file_stem(""), "asset");
    EXPECT_EQ(file_stem(std::string(1000, 'a')).size(), 64u);
}

TEST(Text, NumbersKeepThreeDigitsAndGroupThousands) {
    EXPECT_EQ(format_number(0.0), "0");
    EXPECT_EQ(format_number(0.0123456), "0.0123");
    EXPECT_EQ(format_number(9.996), "10");
    EXPECT_EQ(format_number(99.96), "100");
    EXPECT_EQ(format_number(999.6), "1,000");
    EXPECT_EQ(format_number(-1234567.0), "-1,234,567");
    EXPECT_EQ(format_number(-123456.0), "-123,456");
    EXPECT_EQ(format_number(1.23e-5), "1.2e-05");
    EXPECT_EQ(format_count(18'446'744'073'709'551'615u), "18,446,744,073,709,551,615");
    EXPECT_EQ(format_count(999), "999");
}

TEST(Text, NumbersThatAreNotFiniteAreADash) {
    for (const double value : {std::nan(""), std::numeric_limits<double>::infinity()}) {
        EXPECT_EQ(format_number(value), "–");
        EXPECT_EQ(format_bytes(value), "–");
        EXPECT_EQ(format_duration(value), "–");
    }
}

TEST(Text, BytesAndDurationsTakeTheUnitThatFits) {
    EXPECT_EQ(format_bytes(999), "999 bytes");
    EXPECT_EQ(format_bytes(12'340), "12.3 KB");
    EXPECT_EQ(format_bytes(999'600), "1 MB");
    EXPECT_EQ(format_duration(0.25), "0.25 ms");
    EXPECT_EQ(format_duration(3400), "3.4 s");
}

TEST(Text, Base64PadsAsTheStandardSays) {
    EXPECT_EQ(base64(""), "");
    EXPECT_EQ(base64("f"), "Zg==");
    EXPECT_EQ(base64("fo"), "Zm8=");
    EXPECT_EQ(base64("foo"), "Zm9v");
    EXPECT_EQ(base64("\xFF\xFE\xFD"), "//79");
}

}  // namespace
}  // namespace lodestream::report
