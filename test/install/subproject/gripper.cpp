#include <type_traits>

#include "musher/actuator/machine_actuator.hpp"

// That it compiles shows that the headers are found; examples/first_module has a real one.
static_assert(std::is_class_v<musher::MachineActuator>);
