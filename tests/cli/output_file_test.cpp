// What commands write, and what they must not lose by it.
#include "cli/output_file.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>

#include "cli/interrupt.h"
#include "cli/run_kinora.h"
#include "core/error.h"

namespace kinora::cli {
namespace {

using test::contents_of;
using test::names_in;
using Names = std::vector<std::string>;

class Outputs : public testing::Test {
protected:
  std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }
  Names names() const { return names_in(folder_.path()); }

  /// The sentence, which names the file.
  static std::string refusal_of(const std::function<void()>& work, const std::filesystem::path& file) {
    try {
      work();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUnwritableOutput);
      EXPECT_NE(std::string(error.what()).find(file.string() + " cannot be written"), std::string::npos);
      return error.what();
    }
    return "it is not refused";
  }

  test::TemporaryFolder folder_;
};

TEST_F(Outputs, AppearWholeOrNotAtAll) {
  {
    OutputFile file(path("a"), false);
    EXPECT_EQ(names(), (Names{"a.part"}));
  }
  EXPECT_EQ(names(), Names{});
  OutputFile file(path("a"), false);
  write_text(file, "text");
  EXPECT_EQ(names(), (Names{"a"}));
  EXPECT_EQ(contents_of(path("a")), "text");
}

TEST_F(Outputs, OfOneCommandAreNeverOneFile) {
  std::filesystem::create_directory(path("sub"));
  const OutputFile clip(path("x.mkv"), false);
  for (const std::string name : {"x.mkv", "sub/../x.mkv", "./x.mkv"}) {
    EXPECT_NE(refusal_of([&] { OutputFile(path(name), true); }, path(name)).find("same name"), std::string::npos);
  }
  EXPECT_EQ(names(), (Names{"x.mkv.part"}));
}

TEST_F(Outputs, OfOneCommandAreNeverOneFileByWayOfALink) {
  folder_.write("old.mkv", "mine");
  std::filesystem::create_symlink(path("old.mkv"), path("soft.mkv"));
  std::filesystem::create_hard_link(path("old.mkv"), path("hard.mkv"));
  const OutputFile clip(path("old.mkv"), true);
  for (const std::string name : {"soft.mkv", "hard.mkv"}) {
    EXPECT_NE(refusal_of([&] { OutputFile(path(name), true); }, path(name)).find("same name"), std::string::npos);
  }
  EXPECT_EQ(contents_of(path("old.mkv")), "mine");
}

TEST_F(Outputs, ThatAreDoneMayBeWrittenAgainByTheNext) {
  for (const std::string text : {"first", "second"}) {
    OutputFile file(path("a"), true);
    write_text(file, text);
  }
  EXPECT_EQ(contents_of(path("a")), "second");
}

TEST_F(Outputs, AreNeverAnInput) {
  folder_.write("in", "mine");
  std::filesystem::create_symlink(path("in"), path("link"));
  for (const std::string name : {"in", "link"}) {
    EXPECT_NE(refusal_of([&] { OutputFile(path(name), true, {path("in")}); }, path(name)).find("also the input"),
              std::string::npos);
  }
}

TEST_F(Outputs, LeaveAloneWhatHasTheNameOfSomethingUnfinished) {
  folder_.write("a.part", "mine");
  folder_.write("a.2.part/notes", "mine");
  {
    OutputFile file(path("a"), false);
    write_text(file, "text");
    const Unfinished folder(path("a"), Unfinished::Kind::kFolder);
    EXPECT_TRUE(std::filesystem::is_directory(path("a.3.part")));
  }
  EXPECT_EQ(names(), (Names{"a", "a.2.part/notes", "a.part"}));
  EXPECT_EQ(contents_of(path("a.part")), "mine");
}

TEST_F(Outputs, DoNotReplaceWhatAppearedMeanwhile) {
  OutputFile file(path("a"), false);
  folder_.write("a", "mine");
  const std::string said = refusal_of([&] { write_text(file, "text"); }, path("a"));
  EXPECT_NE(said.find("a.part"), std::string::npos) << said;
  EXPECT_EQ(contents_of(path("a")), "mine");
  EXPECT_EQ(contents_of(path("a.part")), "text");
}

TEST_F(Outputs, AreAskedForBeforeTheyReplaceALinkThatLeadsNowhere) {
  std::filesystem::create_symlink(path("nowhere"), path("link"));
  EXPECT_NE(refusal_of([&] { OutputFile(path("link"), false); }, path("link")).find("--overwrite"), std::string::npos);
}

/// A process with two unfinished files and a folder, which it keeps filling, until it is told to stop.
pid_t busy_process(const std::filesystem::path& folder, int ready) {
  const pid_t pid = fork();
  if (pid != 0) return pid;
  alarm(60); // it does not outlive a test that fails
  handle_signals();
  const OutputFile clip(folder / "clip.mkv", true);
  const OutputFile report(folder / "report.json", false);
  const Unfinished pictures(folder / "pictures", Unfinished::Kind::kFolder);
  const auto fill = [&](int i) { std::ofstream(pictures.path() / std::to_string(i)) << "a picture"; };
  for (int i = 0; i < 3; ++i) fill(i);
  (void)!write(ready, "x", 1);
  for (int i = 3; true; ++i) fill(i % 100);
}

TEST_F(Outputs, OfAProgramThatIsInterruptedTwiceAreAllRemoved) {
  folder_.write("clip.mkv", "mine");
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t pid = busy_process(folder_.path(), ends[1]);
  char ready = 0;
  ASSERT_EQ(read(ends[0], &ready, 1), 1);
  EXPECT_GT(names().size(), 4U);
  kill(pid, SIGINT); // two that are not one: neither swallows the other
  kill(pid, SIGTERM);
  int status = 0;
  waitpid(pid, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_EQ(names(), (Names{"clip.mkv"}));
  EXPECT_EQ(contents_of(path("clip.mkv")), "mine");
  close(ends[0]);
  close(ends[1]);
}

} // namespace
} // namespace kinora::cli
