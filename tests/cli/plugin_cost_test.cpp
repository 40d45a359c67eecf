// Plugins that are there and not needed cost nothing: nobody looks at them.
#include "cli/run_kinora.h"

namespace kinora::test {
namespace {

/// A plugin that is warned of as soon as its plugin.json is read, or its library is opened.
void write_plugins(const TemporaryFolder& folder, int count) {
  for (int i = 0; i < count; ++i) {
    const std::string name = "plugin" + std::to_string(i);
    folder.write(name + "/plugin.json", "no JSON");
    folder.write(name + ".so", "no library");
  }
}

TEST(PluginCost, HelpLooksAtNoPlugin) {
  const TemporaryFolder plugins, out;
  write_plugins(plugins, 50);
  ASSERT_EQ(setenv("KINORA_PLUGIN_PATH", plugins.path().c_str(), 1), 0);
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"--help"}, {"--version"}, {"convert", "--help"}, {"record", "--help"}}) {
    const Said said = run_kinora(out, words);
    EXPECT_EQ(said.code, 0);
    EXPECT_EQ(said.err, "");
  }
  const Said formats = run_kinora(out, {"formats"});
  EXPECT_NE(formats.err.find("plugin left out"), std::string::npos) << "what looks at plugins is told of these";
  unsetenv("KINORA_PLUGIN_PATH");
}

} // namespace
} // namespace kinora::test
