// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/run_directory.hpp"

#include <gtest/gtest.h>

#include "osteomill/base/error.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

namespace fs = std::filesystem;

void write_run(const fs::path& folder, const std::string& picture, const std::string& text) {
  RunDirectory run(folder);
  write_text_file(run.file(picture), text);
  write_text_file(run.file("run.json"), "{}");
  run.commit();
}

TEST(RunDirectory, ReplacesAFormerRunAndKeepsWhatIsNotOfIt) {
  const fs::path folder = scratch("replaced") / "nested";
  write_run(folder, "force.png", "first");
  write_text_file(folder / "notes.txt", "mine");
  write_run(folder, "feed.png", "second");
  EXPECT_FALSE(fs::exists(folder / "force.png"));
  EXPECT_EQ(read_text_file(folder / "feed.png"), "second");
  EXPECT_EQ(read_text_file(folder / "notes.txt"), "mine");
  EXPECT_FALSE(fs::exists(folder / ".unfinished"));
}

TEST(RunDirectory, ARunThatFailsLeavesNothingOrTheFormerRun) {
  const fs::path folder = scratch("failed");
  {
    const RunDirectory run(folder);
    write_text_file(run.file("force.png"), "half");
  }
  EXPECT_FALSE(fs::exists(folder));
  write_run(folder, "force.png", "whole");
  {
    const RunDirectory run(folder);
    write_text_file(run.file("force.png"), "half");
    EXPECT_EQ(read_text_file(folder / "force.png"), "whole");
  }
  EXPECT_EQ(read_text_file(folder / "force.png"), "whole");
  EXPECT_TRUE(fs::exists(folder / "run.json"));
  RunDirectory markless(folder);
  EXPECT_THROW(markless.commit(), WorldError);
}

TEST(RunDirectory, RefusesToWriteOverOtherThings) {
  const fs::path folder = scratch("other");
  fs::create_directories(folder);
  write_text_file(folder / "thesis.tex", "years of work");
  EXPECT_THROW(RunDirectory{folder}, InvalidInput);
  EXPECT_THROW(RunDirectory{folder / "thesis.tex"}, InvalidInput);
  EXPECT_EQ(read_text_file(folder / "thesis.tex"), "years of work");
  EXPECT_THROW(RunDirectory{"/proc/no such folder"}, WorldError);
}

TEST(RunDirectory, AChangedListOfFilesLeadsNowhereElse) {
  const fs::path folder = scratch("list");
  write_run(folder, "force.png", "first");
  write_text_file(folder.parent_path() / "precious.txt", "keep");
  write_text_file(folder / ".files", "../precious.txt\n..\n.\n\n");
  write_run(folder, "feed.png", "second");
  EXPECT_EQ(read_text_file(folder.parent_path() / "precious.txt"), "keep");
  EXPECT_EQ(read_text_file(folder / "feed.png"), "second");
}

}  // namespace
}  // namespace osteomill::io
