# For builds without CMake: a file of pkg-config for each library, made from its target: musher-actuator.pc for
# musher::actuator, which links that library and what it uses. musher.pc is that of a module or an application.

# musher_pkg_config_words(<target> <out packages> <out flags> <library>...) sets by which packages and flags
# pkg-config links libraries that `target` links.
function(musher_pkg_config_words target out_packages out_flags)
  set(packages)
  set(flags)
  foreach(library ${ARGN})
    if(library MATCHES "^musher::(.+)$")
      list(APPEND packages musher-${CMAKE_MATCH_1})
    elseif(library STREQUAL "OpenSSL::Crypto")
      list(APPEND packages libcrypto)
    elseif(library STREQUAL "ZLIB::ZLIB")
      list(APPEND packages zlib)
    elseif(library STREQUAL "tinyxml2::tinyxml2")
      list(APPEND packages tinyxml2)
    elseif(library STREQUAL "SQLiteCpp")  # has no file of its own
      list(APPEND flags -lSQLiteCpp)
      list(APPEND packages sqlite3)
    elseif(library STREQUAL "tomlplusplus::tomlplusplus")  # its flags are for those who include it
      list(APPEND flags -ltomlplusplus)
    elseif(library STREQUAL "CycloneDDS::ddsc")
      list(APPEND flags -lddsc)
    elseif(library STREQUAL "Threads::Threads")
      list(APPEND flags -pthread)
    elseif(library STREQUAL SYSTEMD_LIBRARY)
      list(APPEND packages libsystemd)
    elseif(library STREQUAL "dl")  # CMAKE_DL_LIBS
      list(APPEND flags -ldl)
    elseif(library STREQUAL ZMQ_LIBRARY)
      list(APPEND flags -lzmq)
    else()
      message(FATAL_ERROR "${target} links ${library}: how does pkg-config? See cmake/MusherPkgConfig.cmake.")
    endif()
  endforeach()
  list(JOIN packages " " packages)
  list(JOIN flags " " flags)
  set(${out_packages} "${packages}" PARENT_SCOPE)
  set(${out_flags} "${flags}" PARENT_SCOPE)
endfunction()

file(RELATIVE_PATH prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" prefix "${prefix}")
# musher_pkg_config(<name> <description> <lines>) installs a file for wherever the installation is.
function(musher_pkg_config name description lines)
  set(file ${PROJECT_BINARY_DIR}/pkgconfig/${name}.pc)
  file(GENERATE OUTPUT ${file} CONTENT "prefix=\${pcfiledir}/${prefix}
libdir=\${prefix}/${CMAKE_INSTALL_LIBDIR}
includedir=\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}

Name: ${name}
Description: ${description}
Version: ${PROJECT_VERSION}
${lines}
")
  install(FILES ${file} DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()

foreach(target ${targets})
  get_target_property(name ${target} EXPORT_NAME)
  get_target_property(all ${target} LINK_LIBRARIES)
  get_target_property(public ${target} INTERFACE_LINK_LIBRARIES)
  foreach(list all public)
    list(FILTER ${list} EXCLUDE REGEX "LINK_ONLY|NOTFOUND")  # not found: it links nothing
  endforeach()
  if(MUSHER_SHARED)
    set(private ${all})
    list(REMOVE_ITEM private ${public})
  else()  # a program links all of them
    set(public ${all})
    set(private)
  endif()
  musher_pkg_config_words(${target} packages flags ${public})
  musher_pkg_config_words(${target} own_packages own_flags ${private})
  musher_pkg_config(musher-${name} "The library musher::${name} of Musher" "Requires: ${packages}
Requires.private: ${own_packages}
Cflags: -I\${includedir} -std=c++20
Libs: -L\${libdir} -l${target} ${flags}
Libs.private: ${own_flags}")
endforeach()
musher_pkg_config(musher "${PROJECT_DESCRIPTION}" "Requires: musher-application")
