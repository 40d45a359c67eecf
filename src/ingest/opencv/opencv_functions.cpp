#include "ingest/opencv/opencv_functions.h"

#include "core/module.h"

namespace kinora::ingest {

const OpenCvFunctions& opencv_functions() {
  using Entry = const OpenCvFunctions* (*)();
  static const OpenCvFunctions* const functions =
      reinterpret_cast<Entry>(module_symbol("opencv", "kinora_functions",
                                            "to segment pictures and to correct what a capture says of its "
                                            "cameras"))();
  return *functions;
}

} // namespace kinora::ingest
