# cpack: the Debian packages, one for each component of the installation. A component that nothing installs
# into makes no package.
#
#   component  package         what
#   core       musher          the controller, musher-exec, completion, manual pages, the unit of systemd
#   modules    musher-modules  the programs of modules/ and their configs
#   view       musher-view     web page, recording
#   dev        libmusher-dev   libraries, headers, find_package(musher), messages for ROS 2, tutorials
#   doc        musher-doc      this documentation as a site
#   python     python3-musher  the Python package
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "Musher")
# .invalid never exists (RFC 2606): a distributor of packages sets an address that is read.
set(MUSHER_PACKAGE_CONTACT "Musher developers <noreply@musher.invalid>" CACHE STRING
    "Maintainer of the Debian packages, as Name <address>")
set(CPACK_PACKAGE_CONTACT "${MUSHER_PACKAGE_CONTACT}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # the first line of each description is its summary
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_MUSHER_STRIP ${CMAKE_STRIP})
if(CMAKE_CROSSCOMPILING AND CMAKE_SYSTEM_PROCESSOR STREQUAL "aarch64")  # otherwise that of the computer
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/packages/complete.cmake)
set(folder ${CMAKE_CURRENT_LIST_DIR}/packages)
# The site is no part of a usual build; without it there is no musher-doc.
set(CPACK_PROJECT_CONFIG_FILE ${folder}/choose.cmake)
set(CPACK_MUSHER_SITE ${PROJECT_BINARY_DIR}/docs/html/index.html)

# Only packaged, not part of an installation by hand: there the computer's settings are left alone.
install(FILES ${folder}/default DESTINATION /etc/default RENAME musher COMPONENT core EXCLUDE_FROM_ALL)

# musher_package(<component> <package> <section> <summary> <description> [DEPENDS <components>]) with the
# first line of a description and its paragraph.
set(CPACK_COMPONENTS_ALL "")
get_cmake_property(installed_components COMPONENTS)
macro(musher_package component package section summary description)
  cmake_parse_arguments(ARG "" "" "DEPENDS" ${ARGN})
  if(${component} IN_LIST installed_components)
    list(APPEND CPACK_COMPONENTS_ALL ${component})
    string(TOUPPER ${component} upper)
    set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
    set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
    set(CPACK_COMPONENT_${upper}_DEPENDS ${ARG_DEPENDS})
    set(CPACK_COMPONENT_${upper}_DESCRIPTION "${summary}\n${description}")
  endif()
endmacro()

musher_package(core musher misc "Lifecycle middleware for robots made of many processes"
"Musher drives a team of robot processes: it starts them, checks them, and
switches all of them together between states such as Active, LowPower, OTA
and Error, over DDS. Every switch has a definite outcome. It uses ROS 2's
wire format and needs no ROS.
.
This package has the program musher with its controller, musher-exec, which
makes an actuator of any existing program, a unit for systemd and an example
robot: musher up /usr/share/musher/examples/robot.toml")
set(CPACK_DEBIAN_CORE_PACKAGE_SUGGESTS "musher-modules, musher-view, elfutils")
set(CPACK_DEBIAN_CORE_PACKAGE_CONTROL_EXTRA
    ${folder}/conffiles ${folder}/prerm ${folder}/postinst ${folder}/postrm)

musher_package(modules musher-modules misc "Modules of a robot for Musher, and a simulated robot"
"Motion, audio, devices, sensors, cameras, vision, navigation and applications
as actuators of Musher, with their command-line tools and configs. Their
hardware may be a simulated one: body, yard, cameras and battery.
.
musher up /usr/share/musher/config/robot.toml" DEPENDS core)
set(CPACK_DEBIAN_MODULES_PACKAGE_DEPENDS
    "fonts-dejavu-core, fonts-wqy-microhei, opencv-data, tesseract-ocr-eng, tesseract-ocr-chi-sim")
set(CPACK_DEBIAN_MODULES_PACKAGE_CONTROL_EXTRA ${folder}/prerm)

musher_package(view musher-view misc "Web page and recordings of a robot under Musher"
"A web page of the robot, also for a phone: its state with the reasons, plans,
history, cameras and the emergency stop; the same port has metrics for
Prometheus and a connection for Foxglove. Recordings are MCAP files." DEPENDS core)
set(CPACK_DEBIAN_VIEW_PACKAGE_CONTROL_EXTRA ${folder}/prerm)

musher_package(dev libmusher-dev libdevel "Libraries and headers to write modules for Musher"
"Static libraries, headers and find_package(musher) for CMake; the messages as
IDL and as packages for ROS 2; the projects of the tutorials in
/usr/share/musher/examples." DEPENDS core)
# What musherConfig.cmake finds, and what the libraries are linked with.
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
    "cyclonedds-dev (>= 0.10.2), libtomlplusplus-dev, libtinyxml2-dev, libsqlitecpp-dev, libsqlite3-dev, libssl-dev (>= 3.0), zlib1g-dev, libzmq3-dev, libsystemd-dev")
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "cmake (>= 3.25), g++ (>= 4:12)")
set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS "libgtest-dev")
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)

musher_package(doc musher-doc doc "Documentation of Musher"
"Guide, tutorials, architecture and reference of Musher as a web site:
/usr/share/doc/musher/html/index.html")
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DOC_PACKAGE_SHLIBDEPS OFF)

musher_package(python python3-musher python "Python package of Musher"
"Modules, applications and clients of Musher in Python: import musher. The
projects of the tutorials are in libmusher-dev." DEPENDS core)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${folder}/python/postinst ${folder}/prerm)
if(MUSHER_PYTHON_EXECUTABLE)  # its extension is built for one version of Python
  execute_process(COMMAND ${MUSHER_PYTHON_EXECUTABLE} -c
    "import sys; a, b = sys.version_info[:2]; print(f'python3 (>= {a}.{b}~), python3 (<< {a}.{b + 1})', end='')"
    OUTPUT_VARIABLE CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS COMMAND_ERROR_IS_FATAL ANY)
endif()

include(CPack)
