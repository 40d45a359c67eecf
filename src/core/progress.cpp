#include "core/progress.h"

#include "core/error.h"

namespace kinora {

void Progress::check() const {
  if (cancelled()) throw Error(ErrorCode::kInterrupted, "interrupted; nothing that existed before was changed");
}

} // namespace kinora
