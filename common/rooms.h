#pragma once

/// The namespaces of the rooms. The names of a room are visible, without a prefix, in the rooms
/// that may include it; a name of the room itself hides them. A room above is not visible, so that
/// the compiler holds the arrows of ARCHITECTURE.md as the linker does.
namespace parray {

namespace base {}
namespace math {}
namespace process {
using namespace base;
}
namespace log {
using namespace process;
}
namespace scene {
using namespace base;
using namespace math;
}  // namespace scene
namespace image {
using namespace scene;
}
namespace schedule {
using namespace image;
}
namespace adaptive {
using namespace schedule;
}
namespace trace {
using namespace image;
}

namespace proto {
using namespace schedule;
}

namespace worker {
using namespace log;
using namespace trace;
using namespace proto;
}  // namespace worker

namespace store {
using namespace proto;
}
namespace replica {
using namespace store;
}
namespace coordinator {
using namespace log;
using namespace trace;
using namespace adaptive;
using namespace replica;
}  // namespace coordinator
namespace http {
using namespace coordinator;
}

namespace picture {
using namespace image;
}
namespace input {
using namespace picture;
}
namespace labels {
using namespace input;
}
namespace farm {
using namespace picture;
using namespace coordinator;
using namespace worker;
}  // namespace farm
namespace denoise {
using namespace trace;
using namespace adaptive;
}  // namespace denoise
namespace postprocess {
using namespace labels;
using namespace farm;
}  // namespace postprocess
namespace output {
using namespace postprocess;
using namespace denoise;
}  // namespace output

namespace child_process {
using namespace process;
using namespace proto;
}  // namespace child_process
namespace audit {
using namespace coordinator;
}
namespace compare {
using namespace picture;
}
namespace verify {
using namespace output;
}
namespace plan {
using namespace output;
using namespace audit;
}  // namespace plan
namespace tradeoff {
using namespace plan;
using namespace child_process;
}  // namespace tradeoff
namespace doctor {
using namespace output;
using namespace child_process;
}  // namespace doctor

namespace commands {
using namespace verify;
using namespace compare;
using namespace doctor;
using namespace tradeoff;
}  // namespace commands
namespace scene_sandbox {
using namespace commands;
}
namespace mpi {
using namespace commands;
}
namespace referee {
using namespace worker;
}

}  // namespace parray
