#pragma once

#include "common/rooms.h"

/// Makes the names of all rooms visible in tests.
namespace parray {

using namespace mpi;
using namespace http;
using namespace scene_sandbox;

}  // namespace parray
