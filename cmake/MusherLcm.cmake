# musher_lcm_types(<target> <file.lcm> <type>...): the C++ types that lcm-gen makes of the definitions in the
# file, included as "<package>/<type>.hpp". LCM's own library is not linked: Musher has its datagrams
# (transport/lcm_socket.hpp), so that only the encoding of the types is LCM's.
function(musher_lcm_types target file)
  file(READ ${file} definitions)
  string(REGEX MATCH "\npackage ([a-z_]+)" _ "${definitions}")
  set(package ${CMAKE_MATCH_1})
  set(folder ${PROJECT_BINARY_DIR}/lcm)
  list(TRANSFORM ARGN PREPEND ${folder}/${package}/ OUTPUT_VARIABLE headers)
  list(TRANSFORM headers APPEND .hpp)
  file(MAKE_DIRECTORY ${folder})
  add_custom_command(OUTPUT ${headers} DEPENDS ${file} VERBATIM
    COMMAND ${LCM_GEN} --cpp --cpp-hpath ${folder} ${file})
  add_custom_target(${target}_headers DEPENDS ${headers})
  add_dependencies(musher_message_headers ${target}_headers)  # scripts/lint makes these
  add_library(${target} INTERFACE)
  target_include_directories(${target} SYSTEM INTERFACE ${folder} ${LCM_INCLUDE_DIR})
  add_dependencies(${target} ${target}_headers)
endfunction()
