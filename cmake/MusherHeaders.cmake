# Every installed header stands alone: a source file that includes nothing before it compiles. Most have
# one, their own, which the preset alone compiles alone; for the others one is made.
set(folders actuator application base behavior cli controller cyberdog lifecycle messages navigation ota search simulation
            transport view wire)
if(MUSHER_MODULES)
  list(APPEND folders modules)
endif()
list(TRANSFORM folders REPLACE "(.+)" "${PROJECT_SOURCE_DIR}/\\1/*.hpp" OUTPUT_VARIABLE patterns)
file(GLOB_RECURSE headers RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS ${patterns})
if(MUSHER_UNITY)  # the build of MUSHER_NIGHTLY; the preset alone shows it of all
  include(PublicHeaders)
  musher_public_headers(headers)
endif()
set(alone)
foreach(header ${headers})
  string(REGEX REPLACE "hpp$" "cpp" own ${PROJECT_SOURCE_DIR}/${header})
  if(EXISTS ${own})
    file(STRINGS ${own} first REGEX "^#include" LIMIT_COUNT 1)
    if(first STREQUAL "#include \"musher/${header}\"")
      continue()
    endif()
  endif()
  string(MAKE_C_IDENTIFIER ${header} name)
  set(source ${PROJECT_BINARY_DIR}/alone/${name}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "#include \"musher/${header}\"\n")
  list(APPEND alone ${source})
endforeach()
set(MUSHER_LIBRARY_HEADERS "")  # precompiled ones would hide what is missing
add_library(musher_headers_alone OBJECT ${alone})
musher_target(musher_headers_alone)
# Not with each build: a minute of a CPU. clang-tidy sees the headers from where they are used.
set(left_out OFF)
if(MUSHER_LINT OR (MUSHER_UNITY AND NOT MUSHER_NIGHTLY))
  set(left_out ON)
endif()
set_target_properties(musher_headers_alone PROPERTIES EXCLUDE_FROM_ALL ${left_out} UNITY_BUILD OFF)
target_compile_options(musher_headers_alone PRIVATE -O0 -g0)
target_include_directories(musher_headers_alone PRIVATE ${MUSHER_INCLUDE_DIR})
target_link_libraries(musher_headers_alone
  PRIVATE CycloneDDS::ddsc $<$<BOOL:${MUSHER_MODULES}>:Eigen3::Eigen>
          $<$<BOOL:${MUSHER_MODULES}>:opencv_core>)
