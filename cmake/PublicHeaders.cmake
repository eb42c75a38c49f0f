# What a robot's project may include: the headers that docs/api describes, those below, and what these include.
# Only they are installed, and each of them compiles alone.

cmake_policy(SET CMP0057 NEW)  # IN_LIST, also in the script of an install

set(MUSHER_ALSO_PUBLIC
  # A module: its config, times, messages.
  base/time.hpp
  base/toml/module_file.hpp
  base/version.hpp
  messages/action.hpp
  messages/cdr.hpp
  messages/stamp.hpp
  messages/yaw.hpp
  # An application: what it checks, draws, saves, records and replays; trees in XML, Groot2.
  application/fsm_recording.hpp
  application/fsm_replay_file.hpp
  application/groot2/groot2_server.hpp
  behavior/fsm/graph.hpp
  behavior/fsm/recorder.hpp
  behavior/fsm/toml/snapshot_toml.hpp
  behavior/skill/check.hpp
  behavior/skill/compose.hpp
  behavior/skill/snapshot.hpp
  behavior/skill/toml/skills_toml.hpp
  behavior/skill/toml/snapshot_toml.hpp
  behavior/skill/wait.hpp
  behavior/tree/btcpp.hpp
  behavior/tree/build.hpp
  behavior/tree/json/boards_json.hpp
  behavior/tree/json/json_fields.hpp
  behavior/tree/json/substitutions.hpp
  behavior/tree/models.hpp
  behavior/tree/nav2/nodes.hpp
  behavior/tree/plugin/load_plugin.hpp
  behavior/tree/plugin/plugin.hpp
  behavior/tree/xml/tree_xml.hpp
  # A program that leads, commands or watches a machine, also CyberDog's.
  cyberdog/codes/module_codes.hpp
  cyberdog/extension.hpp
  cyberdog/machine.hpp
  transport/linux_event_loop.hpp
  wire/lifecycle_wire.hpp
  wire/managed_node_endpoints.hpp)

# Sets `out` to all of them, relative to the source of Musher, but for those that are generated from the IDL.
function(musher_public_headers out)
  set(open ${MUSHER_ALSO_PUBLIC})
  file(GLOB pages ${PROJECT_SOURCE_DIR}/docs/api/*.md)
  foreach(page ${pages})
    file(STRINGS ${page} described REGEX "^```{header} ")
    list(TRANSFORM described REPLACE "^```{header} " "")
    list(APPEND open ${described})
  endforeach()
  foreach(header ${open})
    if(NOT EXISTS ${PROJECT_SOURCE_DIR}/${header})
      message(FATAL_ERROR "There is no header ${header}; it is named in docs/api or cmake/PublicHeaders.cmake.")
    endif()
  endforeach()

  set(public)
  while(open)
    list(POP_FRONT open header)
    if(header IN_LIST public OR NOT EXISTS ${PROJECT_SOURCE_DIR}/${header})  # a generated one
      continue()
    endif()
    list(APPEND public ${header})
    file(STRINGS ${PROJECT_SOURCE_DIR}/${header} includes REGEX "^#include \"musher/")
    list(TRANSFORM includes REPLACE "^#include \"musher/([^\"]+)\".*" "\\1")
    list(APPEND open ${includes})
  endwhile()
  list(SORT public)
  set(${out} ${public} PARENT_SCOPE)
endfunction()
