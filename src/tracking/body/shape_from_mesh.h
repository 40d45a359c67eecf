// A person's measures from a mesh of that person.
#pragma once

#include "ingest/files/body_mesh.h"
#include "tracking/body/body_prior.h"

namespace kinora::tracking {

/// Our skeleton at the size of the mesh: lengths of limbs from its joints, everything else from its surface. The
/// prior's pose is the mesh's own, as far as our cones can take it; its precision leaves room for clothes. Finite for
/// every mesh that read_body_mesh() returns; same bits for any number of threads.
BodyPrior measure_body(const ingest::BodyMesh& mesh);

} // namespace kinora::tracking
