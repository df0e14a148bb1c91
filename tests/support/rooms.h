#pragma once

#include "common/rooms.h"

/// Tests see the names of all rooms.
namespace parray {

using namespace mpi;
using namespace http;
using namespace scene_sandbox;

}  // namespace parray
