#include "encode/settings.h"

namespace kinora::encode {

SettingList list_settings(Settings& settings) { return SettingList(settings); }

nlohmann::json settings_json(Settings settings) { return list_settings(settings).json(); }

} // namespace kinora::encode
