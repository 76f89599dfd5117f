// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/csv_file.hpp"

#include <gmock/gmock.h>

#include "osteomill/base/error.hpp"

namespace osteomill::io {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(CsvFile, ReadsQuotesLineBreaksRemarksAndCountsLines) {
  const CsvFile file = parse_csv(
      "\xEF\xBB\xBF# who, when\r\na, \"b,c\" ,d\r\n\r\n1,\"say \"\"no\"\"\nor yes\", 2 \r\n3,,\n",
      "t.csv");
  EXPECT_THAT(file.columns, ElementsAre("a", "b,c", "d"));
  ASSERT_EQ(file.rows.size(), 2u);
  EXPECT_THAT(file.rows[0].cells, ElementsAre("1", "say \"no\"\nor yes", "2"));
  EXPECT_EQ(file.rows[0].line, 4);
  EXPECT_THAT(file.rows[1].cells, ElementsAre("3", "", ""));
  EXPECT_EQ(file.rows[1].line, 6);
}

TEST(CsvFile, TakesTheSeparatorFromTheHeading) {
  EXPECT_THAT(parse_csv("a;b\n1,5;2\n", "t").rows[0].cells, ElementsAre("1,5", "2"));
  EXPECT_THAT(parse_csv("a\tb\n1\t2", "t").rows[0].cells, ElementsAre("1", "2"));
  EXPECT_THAT(parse_csv("only\n1\n", "t").rows[0].cells, ElementsAre("1"));
}

struct Bad {
  const char* text;
  std::vector<const char*> says;
};

TEST(CsvFile, NamesEveryFaultWithItsLine) {
  const std::vector<Bad> table = {
      {"", {"is empty"}},
      {"# nothing\n", {"is empty"}},
      {"a,a,\n1,2,3\n", {"t.csv:1: heading = a: stands twice", "a column has no name"}},
      {"a,b\n1\n1,2,3\n", {"t.csv:2: row = 1 cells", "t.csv:3: row = 3 cells"}},
      {"a,b\n1,\"2\n", {"t.csv:2: quotes: are opened and not closed"}},
  };
  for (const Bad& bad : table) {
    try {
      parse_csv(bad.text, "t.csv");
      ADD_FAILURE() << bad.text;
    } catch (const InvalidInput& error) {
      for (const char* part : bad.says) EXPECT_THAT(error.what(), HasSubstr(part));
    }
  }
}

}  // namespace
}  // namespace osteomill::io
