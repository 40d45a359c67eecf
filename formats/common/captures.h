// The functions of formats that read or write captures, from a C++ class each.
#pragma once

#include "common/writers.h"

namespace kinora::formats {

/// A probe reads files, and files may vanish or be forbidden: then it is none of ours.
template <void (*probe)(const char*, KinoraProbe*)> void safe_probe(const char* path, KinoraProbe* answer) {
  try {
    probe(path, answer);
  } catch (const std::exception& error) {
    answer_probe(answer, 0, error.what());
  } catch (...) {
    answer_probe(answer, 0, "an unknown exception");
  }
}

/// Reader has fill_info(KinoraCaptureInfo&) const, next(KinoraFrame&) and, unless it only goes forwards,
/// seek(std::int64_t). An Error(kCorruptInput) from next() is of that frame alone. If sound comes with the frames, it
/// has fill_sound(KinoraSound&) and next_sound(KinoraSoundPacket&), which return false where there is none.
template <class Reader, std::unique_ptr<Reader> (*open)(const char* path, const OptionMap& options)>
constexpr void set_reader(KinoraFormat& format) {
  format.capabilities |= KINORA_READS_FRAMES;
  format.open_reader = [](const char* path, const KinoraOptionValue* options, size_t option_count,
                          KinoraReader** reader, KinoraMessage* message) {
    return guarded(message, [&] {
      *reader = reinterpret_cast<KinoraReader*>(open(path, option_map(options, option_count)).release());
      return KinoraStatus{KINORA_OK};
    });
  };
  format.reader_info = [](KinoraReader* reader, KinoraCaptureInfo* info, KinoraMessage* message) {
    return guarded(message, [&] {
      reinterpret_cast<Reader*>(reader)->fill_info(*info);
      return KinoraStatus{KINORA_OK};
    });
  };
  format.reader_next = [](KinoraReader* reader, KinoraFrame* frame, KinoraMessage* message) {
    const KinoraStatus status =
        guarded(message, [&]() -> KinoraStatus { return reinterpret_cast<Reader*>(reader)->next(*frame); });
    return status == KINORA_CORRUPT ? KinoraStatus{KINORA_BAD_FRAME} : status;
  };
  if constexpr (requires(Reader & reader) { reader.seek(0); }) {
    format.capabilities |= KINORA_SEEKS;
    format.reader_seek = [](KinoraReader* reader, int64_t index, KinoraMessage* message) {
      return guarded(message, [&] {
        reinterpret_cast<Reader*>(reader)->seek(index);
        return KinoraStatus{KINORA_OK};
      });
    };
  }
  if constexpr (requires(Reader & reader, KinoraSound & sound) { reader.fill_sound(sound); }) {
    format.capabilities |= KINORA_READS_SOUND;
    format.reader_sound = [](KinoraReader* reader, KinoraSound* sound, KinoraMessage* message) {
      return guarded(message, [&]() -> KinoraStatus {
        return reinterpret_cast<Reader*>(reader)->fill_sound(*sound) ? KINORA_OK : KINORA_END;
      });
    };
    format.reader_sound_packet = [](KinoraReader* reader, KinoraSoundPacket* packet, KinoraMessage* message) {
      return guarded(message, [&]() -> KinoraStatus {
        return reinterpret_cast<Reader*>(reader)->next_sound(*packet) ? KINORA_OK : KINORA_END;
      });
    };
  }
  format.reader_close = [](KinoraReader* reader) { delete reinterpret_cast<Reader*>(reader); };
}

/// The format with these functions.
template <class Reader, std::unique_ptr<Reader> (*open)(const char* path, const OptionMap& options)>
constexpr KinoraFormat with_reader(KinoraFormat format) {
  set_reader<Reader, open>(format);
  return format;
}

/// Writer has set_capture(const KinoraCaptureInfo&), write(const KinoraFrame&), which returns why a frame is left out
/// (empty: it is not), and finish(). If it has a place for sound: set_sound(const KinoraSound&) and
/// write_sound(const KinoraSoundPacket&).
template <class Writer, std::unique_ptr<Writer> (*open)(const char* path, const OptionMap& options)>
constexpr void set_writer(KinoraFormat& format) {
  format.capabilities |= KINORA_WRITES_FRAMES;
  set_writer_ends<Writer, open>(format);
  format.writer_capture = [](KinoraWriter* writer, const KinoraCaptureInfo* info, KinoraMessage* message) {
    return guarded(message, [&] {
      reinterpret_cast<Writer*>(writer)->set_capture(*info);
      return KinoraStatus{KINORA_OK};
    });
  };
  format.writer_frame = [](KinoraWriter* writer, const KinoraFrame* frame, KinoraMessage* message) {
    return guarded(message, [&] {
      const std::string why = reinterpret_cast<Writer*>(writer)->write(*frame);
      set_message(message, why.c_str());
      return why.empty() ? KinoraStatus{KINORA_OK} : KinoraStatus{KINORA_BAD_FRAME};
    });
  };
  if constexpr (requires(Writer & writer, const KinoraSound& sound) { writer.set_sound(sound); }) {
    format.capabilities |= KINORA_WRITES_SOUND;
    format.writer_sound = [](KinoraWriter* writer, const KinoraSound* sound, KinoraMessage* message) {
      return guarded(message, [&] {
        reinterpret_cast<Writer*>(writer)->set_sound(*sound);
        return KinoraStatus{KINORA_OK};
      });
    };
    format.writer_sound_packet = [](KinoraWriter* writer, const KinoraSoundPacket* packet, KinoraMessage* message) {
      return guarded(message, [&] {
        reinterpret_cast<Writer*>(writer)->write_sound(*packet);
        return KinoraStatus{KINORA_OK};
      });
    };
  }
}

} // namespace kinora::formats
