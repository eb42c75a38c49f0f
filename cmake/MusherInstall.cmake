# What an installation has besides programs: find_package(musher) for robot projects, configs, examples, the
# unit of systemd.
include(CMakePackageConfigHelpers)
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME dev)

get_property(targets GLOBAL PROPERTY MUSHER_INSTALLED_TARGETS)
install(TARGETS ${targets} EXPORT musherTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT core NAMELINK_COMPONENT dev)
install(EXPORT musherTargets NAMESPACE musher:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/musher)

set(include_to "${CMAKE_INSTALL_INCLUDEDIR}/musher")
if(NOT IS_ABSOLUTE "${include_to}")
  string(PREPEND include_to "\${CMAKE_INSTALL_PREFIX}/")
endif()
# The headers, found when they are installed: what one includes may have changed since the configuration.
install(CODE "
  set(PROJECT_SOURCE_DIR \"${PROJECT_SOURCE_DIR}\")
  include(\"${CMAKE_CURRENT_LIST_DIR}/PublicHeaders.cmake\")
  musher_public_headers(headers)
  foreach(header IN LISTS headers)
    get_filename_component(folder \${header} DIRECTORY)
    file(INSTALL DESTINATION \"${include_to}/\${folder}\"
         TYPE FILE FILES \"${PROJECT_SOURCE_DIR}/\${header}\")
  endforeach()")
install(FILES ${MUSHER_GENERATED_DIR}/musher/behavior/tree/plugin/plugin_version.hpp
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/musher/behavior/tree/plugin)
# A folder of the IDL is a package, whose headers are generated.
file(GLOB packages RELATIVE ${PROJECT_SOURCE_DIR}/messages ${PROJECT_SOURCE_DIR}/messages/*/*.idl)
list(TRANSFORM packages REPLACE "/.*" "")
list(REMOVE_DUPLICATES packages)
foreach(package ${packages})
  install(DIRECTORY ${MUSHER_GENERATED_DIR}/musher/messages/${package}
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/musher/messages)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/messages/${package} DESTINATION ${CMAKE_INSTALL_DATADIR}/musher/idl)
endforeach()
install(DIRECTORY ${PROJECT_BINARY_DIR}/share/musher/ros DESTINATION ${CMAKE_INSTALL_DATADIR}/musher)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/config DESTINATION ${CMAKE_INSTALL_DATADIR}/musher
        USE_SOURCE_PERMISSIONS COMPONENT modules)
# A robot that needs no compiler and no modules, and the projects of the tutorials.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples/robot DESTINATION ${CMAKE_INSTALL_DATADIR}/musher/examples
        COMPONENT core)
install(FILES ${PROJECT_SOURCE_DIR}/examples/robot.toml DESTINATION ${CMAKE_INSTALL_DATADIR}/musher/examples
        COMPONENT core)
# The templates of `musher new`. What is in Python comes with the Python package, which runs it.
file(GLOB templates CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/examples/new_*)
list(FILTER templates EXCLUDE REGEX "/new_python_[a-z]+$")
file(GLOB python_projects CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/examples/new_python_*
     ${PROJECT_SOURCE_DIR}/examples/python_*)
install(DIRECTORY ${templates} DESTINATION ${CMAKE_INSTALL_DATADIR}/musher/examples COMPONENT core
        USE_SOURCE_PERMISSIONS)
install(DIRECTORY ${python_projects} DESTINATION ${CMAKE_INSTALL_DATADIR}/musher/examples COMPONENT python
        USE_SOURCE_PERMISSIONS PATTERN "__pycache__" EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples DESTINATION ${CMAKE_INSTALL_DATADIR}/musher
        USE_SOURCE_PERMISSIONS PATTERN "examples/CMakeLists.txt" EXCLUDE PATTERN "examples/new_*" EXCLUDE
        PATTERN "examples/python_*" EXCLUDE PATTERN "__pycache__" EXCLUDE PATTERN "examples/robot" EXCLUDE PATTERN "examples/robot.toml" EXCLUDE)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT license)

# The unit names the installed program, wherever that is by then.
install(CODE "
  get_filename_component(MUSHER_BIN \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}\" ABSOLUTE)
  configure_file(\"${PROJECT_SOURCE_DIR}/scripts/systemd/musher@.service.in\"
                 \"${PROJECT_BINARY_DIR}/musher@.service\" @ONLY)" COMPONENT core)
install(FILES ${PROJECT_BINARY_DIR}/musher@.service DESTINATION lib/systemd/system COMPONENT core)
# Where the unit looks for configs. An install into a folder of one's own leaves the system alone.
install(CODE "
  if(CMAKE_INSTALL_PREFIX MATCHES \"^/usr(/|$)\")
    file(MAKE_DIRECTORY \"\$ENV{DESTDIR}/etc/musher\")
  endif()" COMPONENT core)

list(TRANSFORM targets REPLACE "^musher_" "" OUTPUT_VARIABLE MUSHER_LIBRARIES)
list(SORT MUSHER_LIBRARIES)
list(JOIN MUSHER_LIBRARIES ", " MUSHER_LIBRARIES)
set(MUSHER_GROOT2 OFF)  # whether ZeroMQ is linked
if(TARGET musher_groot2)
  set(MUSHER_GROOT2 ON)
endif()
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/musherConfig.cmake.in musherConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/musher)
write_basic_package_version_file(musherConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/musherConfig.cmake ${PROJECT_BINARY_DIR}/musherConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/musher)

include(MusherPkgConfig)
