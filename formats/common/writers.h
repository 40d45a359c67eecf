// The functions of formats that write, from a C++ class each.
#pragma once

#include <memory>

#include "common/boundary.h"
#include "common/facts.h"

namespace kinora::formats {

using OptionMap = std::map<std::string, std::string>;

/// Whether an option is given as "true"; without it `otherwise`.
inline bool option_is_set(const OptionMap& options, const char* name, bool otherwise) {
  const auto given = options.find(name);
  return given == options.end() ? otherwise : given->second == "true";
}

/// The text of an option, or `otherwise`.
inline std::string option_text(const OptionMap& options, const char* name, const char* otherwise = "") {
  const auto given = options.find(name);
  return given == options.end() ? otherwise : given->second;
}

/// The number of an option, or `otherwise`. The host has checked that it is one.
inline double option_number(const OptionMap& options, const char* name, double otherwise) {
  const auto given = options.find(name);
  return given == options.end() ? otherwise : std::stod(given->second);
}

/// How a writer begins and ends. Writer has finish() and, if its output has a place for texts, describe(Facts), which
/// comes first.
template <class Writer, std::unique_ptr<Writer> (*open)(const char* path, const OptionMap& options)>
constexpr void set_writer_ends(KinoraFormat& format) {
  format.open_writer = [](const char* path, const KinoraOptionValue* options, size_t option_count,
                          KinoraWriter** writer, KinoraMessage* message) {
    return guarded(message, [&] {
      *writer = reinterpret_cast<KinoraWriter*>(open(path, option_map(options, option_count)).release());
      return KinoraStatus{KINORA_OK};
    });
  };
  format.writer_finish = [](KinoraWriter* writer, KinoraMessage* message) {
    const std::unique_ptr<Writer> owned(reinterpret_cast<Writer*>(writer));
    return guarded(message, [&] {
      owned->finish();
      return KinoraStatus{KINORA_OK};
    });
  };
  format.writer_abandon = [](KinoraWriter* writer) { delete reinterpret_cast<Writer*>(writer); };
  if constexpr (requires(Writer & writer, Facts facts) { writer.describe(std::move(facts)); }) {
    format.writer_facts = [](KinoraWriter* writer, const KinoraOptionValue* facts, size_t count,
                             KinoraMessage* message) {
      return guarded(message, [&] {
        reinterpret_cast<Writer*>(writer)->describe(facts_of(facts, count));
        return KinoraStatus{KINORA_OK};
      });
    };
  }
}

/// Writer has write(const KinoraPicture&) and finish().
template <class Writer, std::unique_ptr<Writer> (*open)(const char* path, const OptionMap& options)>
constexpr void set_picture_writer(KinoraFormat& format) {
  set_writer_ends<Writer, open>(format);
  format.writer_write = [](KinoraWriter* writer, const KinoraPicture* picture, KinoraMessage* message) {
    return guarded(message, [&] {
      reinterpret_cast<Writer*>(writer)->write(*picture);
      return KinoraStatus{KINORA_OK};
    });
  };
}

/// Writer has add(const KinoraMesh&), finish() and, if its meshes move, pose(const KinoraMeshPose&).
template <class Writer, std::unique_ptr<Writer> (*open)(const char* path, const OptionMap& options)>
constexpr void set_mesh_writer(KinoraFormat& format) {
  set_writer_ends<Writer, open>(format);
  format.writer_mesh = [](KinoraWriter* writer, const KinoraMesh* mesh, KinoraMessage* message) {
    return guarded(message, [&] {
      reinterpret_cast<Writer*>(writer)->add(*mesh);
      return KinoraStatus{KINORA_OK};
    });
  };
  if constexpr (requires(Writer & writer, const KinoraMeshPose& pose) { writer.pose(pose); }) {
    format.writer_pose = [](KinoraWriter* writer, const KinoraMeshPose* pose, KinoraMessage* message) {
      return guarded(message, [&] {
        reinterpret_cast<Writer*>(writer)->pose(*pose);
        return KinoraStatus{KINORA_OK};
      });
    };
  }
}

/// Writer has write(const KinoraVolume&) and finish().
template <class Writer, std::unique_ptr<Writer> (*open)(const char* path, const OptionMap& options)>
constexpr void set_volume_writer(KinoraFormat& format) {
  set_writer_ends<Writer, open>(format);
  format.writer_volume = [](KinoraWriter* writer, const KinoraVolume* volume, KinoraMessage* message) {
    return guarded(message, [&] {
      reinterpret_cast<Writer*>(writer)->write(*volume);
      return KinoraStatus{KINORA_OK};
    });
  };
}

} // namespace kinora::formats
