// Settings are listed, changed by name and read back, whatever struct they are in.
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"
#include "encode/encode_options.h"

namespace kinora::encode {
namespace {

using Json = nlohmann::json;

enum class Shade { kLight, kHalfDark };

struct Solver {
  std::array<int, 3> iterations{1, 1, 5};
  double gate = 0.1;
  float share = 0.3F;
};

struct Tracker {
  Solver solver;
  std::size_t points = 2500;
  bool searches = true;
};

struct Everything {
  Tracker rigid;
  Tracker camera;
  std::string name = "as it is";
  Shade shade = Shade::kHalfDark;
  std::optional<double> limit = {};
};

std::string refusal_of(Everything& settings, const std::string& assignment) {
  const Json before = settings_json(settings);
  try {
    SettingList(settings).change(assignment);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    EXPECT_EQ(settings_json(settings), before);
    return error.what();
  }
  return "";
}

TEST(SettingList, IsTheTreeOfTheStructs) {
  const Json json = settings_json(Everything{});
  EXPECT_EQ(json.size(), 5U);
  EXPECT_EQ(json["rigid"], Json::parse(R"({"points": 2500, "searches": true,
                                           "solver": {"iterations": [1, 1, 5], "gate": 0.1, "share": 0.3}})"));
  EXPECT_EQ(json["shade"], "half_dark");
  EXPECT_EQ(json["limit"], nullptr);
}

TEST(SettingList, ChangesWhatIsNamed) {
  Everything settings;
  const SettingList list(settings);
  list.change("rigid.solver.gate=0.25");
  EXPECT_EQ(settings.rigid.solver.gate, 0.25);
  EXPECT_EQ(settings.camera.solver.gate, 0.1);
  list.change("rigid.points=7");
  EXPECT_EQ(settings.rigid.points, 7U);
  list.change("rigid.points=2e7");
  EXPECT_EQ(settings.rigid.points, 20'000'000U);
  list.change("camera.searches=false");
  EXPECT_FALSE(settings.camera.searches);
  list.change("name=7");
  EXPECT_EQ(settings.name, "7");
  list.change("name=a=b, c");
  EXPECT_EQ(settings.name, "a=b, c");
  list.change("shade=light");
  EXPECT_EQ(settings.shade, Shade::kLight);
  list.change("limit=3");
  EXPECT_EQ(settings.limit, 3.0);
  list.change("limit=null");
  EXPECT_EQ(settings.limit, std::nullopt);
}

TEST(SettingList, TakesSeveralValuesOrOneForAll) {
  Everything settings;
  SettingList(settings).change("rigid.solver.iterations=3,2,1");
  EXPECT_EQ(settings.rigid.solver.iterations, (std::array<int, 3>{3, 2, 1}));
  SettingList(settings).change("rigid.solver.iterations=[4, 5, 6]");
  EXPECT_EQ(settings.rigid.solver.iterations, (std::array<int, 3>{4, 5, 6}));
  SettingList(settings).change("rigid.solver.iterations=9");
  EXPECT_EQ(settings.rigid.solver.iterations, (std::array<int, 3>{9, 9, 9}));
  EXPECT_NE(refusal_of(settings, "rigid.solver.iterations=1,2"), "");
}

TEST(SettingList, LetsNamesBeLeftOutWhereOneSettingIsMeant) {
  Everything settings;
  SettingList(settings).change("rigid.gate=2");
  EXPECT_EQ(settings.rigid.solver.gate, 2);
  const std::string both = refusal_of(settings, "solver.gate=2");
  EXPECT_NE(both.find("rigid.solver.gate or camera.solver.gate"), std::string::npos) << both;
}

TEST(SettingList, RefusesUnknownNamesWithTheNearest) {
  Everything settings;
  for (const char* wrong : {"rigid.solver.gates=1", "gate.rigid=1", "rigid=1", "=1", "rigid.=1", ".=1"}) {
    const std::string why = refusal_of(settings, wrong);
    EXPECT_NE(why.find("there is no setting"), std::string::npos) << wrong << why;
    EXPECT_NE(why.find("--help-settings"), std::string::npos) << why;
  }
  const std::string why = refusal_of(settings, "rigid.solver.gates=1");
  EXPECT_NE(why.find("the nearest are rigid.solver.gate,"), std::string::npos) << why;
  EXPECT_NE(refusal_of(settings, "rigid.points").find("\"=\""), std::string::npos);
}

TEST(SettingList, RefusesWhatIsNoValue) {
  Everything settings;
  for (const char* wrong :
       {"rigid.points=1.5", "rigid.points=-1", "rigid.points=many", "rigid.points=", "rigid.points=1e30",
        "rigid.gate=-0.1", "rigid.gate=nan", "rigid.gate=1e999", "rigid.gate=true", "rigid.share=1e39",
        "rigid.iterations=3000000000", "rigid.iterations=1,x,2", "rigid.searches=1", "rigid.searches=yes", "shade=dark",
        "limit=low"}) {
    EXPECT_NE(refusal_of(settings, wrong).find(std::string(wrong).substr(std::string(wrong).find('=') + 1)),
              std::string::npos)
        << wrong;
    EXPECT_NE(refusal_of(settings, wrong), "") << wrong;
  }
}

/// A value that a setting may have, and has hardly ever.
Json random_value(const Json& like, Random& random) {
  if (like.is_array()) {
    Json values = Json::array();
    for (const Json& value : like) values.push_back(random_value(value, random));
    return values;
  }
  if (like.is_boolean()) return random.uniform() < 0.5F;
  if (like.is_string())
    return like == "paper" ? "interval" : "paper"; // the one enum that there is: of rules for key frames
  if (like.is_number_float()) return static_cast<double>(random.uniform()) * 12.3;
  return static_cast<int>(random.uniform() * 1e6F);
}

TEST(Settings, AreReadBackAsTheyWereWritten) {
  Random random(1, 2);
  for (int i = 0; i < 20; ++i) {
    Settings written;
    for (const Setting& setting : list_settings(written).all()) {
      ASSERT_TRUE(setting.set(random_value(setting.get(), random))) << setting.path;
    }
    const Json json = Json::parse(settings_json(written).dump());
    Settings read;
    for (const Setting& setting : list_settings(read).all()) {
      std::string pointer = '/' + setting.path;
      std::replace(pointer.begin(), pointer.end(), '.', '/');
      ASSERT_TRUE(setting.set(json.at(Json::json_pointer(pointer)))) << setting.path;
    }
    EXPECT_EQ(settings_json(read), json);
    EXPECT_EQ(read.tracking.rigid.search.rotation, written.tracking.rigid.search.rotation);
    EXPECT_EQ(read.fields.trainer.loss.opacity, written.fields.trainer.loss.opacity);
  }
}

TEST(Settings, CanEachBeSetByWhatTheirListSays) {
  Settings defaults;
  const SettingList list = list_settings(defaults);
  EXPECT_GT(list.all().size(), 150U);
  const std::string text = list.text();
  Random random(3, 4);
  for (const Setting& setting : list.all()) {
    EXPECT_NE(text.find("  " + setting.path + " "), std::string::npos);
    Settings changed;
    Json value = random_value(setting.get(), random);
    if (value.is_boolean()) value = !setting.get().get<bool>();
    list_settings(changed).change(setting.path + '=' + value.dump());
    const Json difference = Json::diff(settings_json(defaults), settings_json(changed));
    ASSERT_FALSE(difference.empty()) << setting.path;
    std::string pointer = '/' + setting.path;
    std::replace(pointer.begin(), pointer.end(), '.', '/');
    for (const Json& change : difference) {
      EXPECT_EQ(change.at("path").get<std::string>().find(pointer), 0U) << setting.path << " changes " << change;
    }
  }
}

TEST(Settings, KnowTheSolverByItsShortPath) {
  Settings settings;
  list_settings(settings).change("tracking.solver.iterations=3");
  EXPECT_EQ(settings.tracking.deforming.in_view.solver.iterations, (std::array<int, 3>{3, 3, 3}));
}

TEST(Settings, AreNotZeroWhereThatIsDividedBy) {
  EXPECT_NO_THROW(check(Settings{}));
  for (const char* path : {"solver.prior_sigma", "camera.references", "trainer.rays_per_step", "motion.arm_rotation"}) {
    Settings settings;
    list_settings(settings).change(std::string(path) + "=0");
    EXPECT_THROW(check(settings), Error) << path;
  }
  Settings settings;
  list_settings(settings).change("solver.photometric_weight=0");
  EXPECT_NO_THROW(check(settings));
}

TEST(Settings, ComeFromThePresetFirst) {
  EncodeOptions options = EncodeOptions::of(Preset::kFast);
  EXPECT_EQ(options.settings.budget.decibels_per_second, 10);
  list_settings(options.settings).change("budget.decibels_per_second=3");
  EXPECT_EQ(options.settings.budget.decibels_per_second, 3);
}

} // namespace
} // namespace kinora::encode
