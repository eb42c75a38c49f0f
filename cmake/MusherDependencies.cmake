# Every library Musher needs, each a Debian package. A missing one ends the configuration with the
# name of the package and of the script that installs them all.
function(musher_require package debian_package)
  find_package(${package} ${ARGN} QUIET)
  if(NOT ${package}_FOUND)
    message(FATAL_ERROR "Musher needs ${package} (Debian package ${debian_package}). "
                        "Run scripts/bootstrap to install everything the build needs.")
  endif()
endfunction()

macro(musher_dependency package debian_package)
  musher_require(${package} ${debian_package} ${ARGN})
  find_package(${package} ${ARGN} QUIET)
endmacro()

musher_dependency(CycloneDDS cyclonedds-dev 0.10.2)
musher_dependency(tomlplusplus libtomlplusplus-dev)
musher_dependency(tinyxml2 libtinyxml2-dev)
# Debian 13's asks for a macro that has no effect where a pointer has 64 bits, but with which GCC does not read headers
# that were precompiled without it.
get_target_property(asked tinyxml2::tinyxml2 INTERFACE_COMPILE_DEFINITIONS)
if(asked AND CMAKE_SIZEOF_VOID_P EQUAL 8)
  list(REMOVE_ITEM asked _FILE_OFFSET_BITS=64)
  set_target_properties(tinyxml2::tinyxml2 PROPERTIES INTERFACE_COMPILE_DEFINITIONS "${asked}")
endif()
musher_dependency(fmt libfmt-dev)
musher_dependency(SQLiteCpp libsqlitecpp-dev)
musher_dependency(OpenSSL libssl-dev 3.0)
musher_dependency(ZLIB zlib1g-dev)
musher_dependency(Threads libc6-dev)
musher_dependency(Python3 python3 COMPONENTS Interpreter)

find_path(CLI11_INCLUDE_DIR CLI/CLI.hpp)
find_path(NLOHMANN_JSON_INCLUDE_DIR nlohmann/json.hpp)
find_program(IDLC idlc)
function(musher_require_found variable debian_package)
  if(NOT ${variable})
    message(FATAL_ERROR "Musher needs the Debian package ${debian_package}. "
                        "Run scripts/bootstrap to install everything the build needs.")
  endif()
endfunction()
musher_require_found(CLI11_INCLUDE_DIR libcli11-dev)
musher_require_found(NLOHMANN_JSON_INCLUDE_DIR nlohmann-json3-dev)
musher_require_found(IDLC cyclonedds-tools)

# For musher::groot2; without the modules it is left out where ZeroMQ is missing.
find_path(ZMQ_INCLUDE_DIR zmq.h)
find_library(ZMQ_LIBRARY zmq)

# For processes on other hosts, which their systemd runs; a state config with [host.*] is an error without it.
find_path(SYSTEMD_INCLUDE_DIR systemd/sd-bus.h)
find_library(SYSTEMD_LIBRARY systemd)
if(SYSTEMD_INCLUDE_DIR AND SYSTEMD_LIBRARY)
  set(MUSHER_HOSTS ON)
else()
  set(MUSHER_HOSTS OFF)
  message(STATUS "libsystemd-dev is missing: processes on other hosts ([host.*]) are left out. "
                 "scripts/bootstrap installs it.")
endif()

if(MUSHER_VIEW)
  musher_dependency(Boost libboost-dev 1.74)
  musher_dependency(OpenCV libopencv-dev COMPONENTS core imgcodecs imgproc)
  musher_dependency(PkgConfig pkg-config)
  pkg_check_modules(ZSTD QUIET IMPORTED_TARGET libzstd)
  pkg_check_modules(LZ4 QUIET IMPORTED_TARGET liblz4)
  musher_require_found(ZSTD_FOUND libzstd-dev)
  musher_require_found(LZ4_FOUND liblz4-dev)
endif()

if(MUSHER_MODULES)
  musher_require_found(ZMQ_INCLUDE_DIR libzmq3-dev)
  musher_require_found(ZMQ_LIBRARY libzmq3-dev)
  musher_dependency(Eigen3 libeigen3-dev)
  musher_dependency(OpenCV libopencv-dev
                    COMPONENTS aruco calib3d core dnn freetype imgcodecs imgproc objdetect videoio)
  musher_dependency(PkgConfig pkg-config)
  pkg_check_modules(ALSA QUIET IMPORTED_TARGET alsa)
  pkg_check_modules(ESPEAK_NG QUIET IMPORTED_TARGET espeak-ng)
  pkg_check_modules(SNDFILE QUIET IMPORTED_TARGET sndfile)
  pkg_check_modules(TESSERACT QUIET IMPORTED_TARGET tesseract)
  pkg_check_modules(ZBAR QUIET IMPORTED_TARGET zbar)
  pkg_check_modules(ZXING QUIET IMPORTED_TARGET zxing)
  pkg_check_modules(OCTOMAP QUIET IMPORTED_TARGET octomap)
  musher_require_found(ALSA_FOUND libasound2-dev)
  musher_require_found(ESPEAK_NG_FOUND libespeak-ng-dev)
  musher_require_found(SNDFILE_FOUND libsndfile1-dev)
  musher_require_found(TESSERACT_FOUND libtesseract-dev)
  musher_require_found(ZBAR_FOUND libzbar-dev)
  musher_require_found(ZXING_FOUND libzxing-dev)
  target_compile_definitions(PkgConfig::ZXING INTERFACE ZX_USE_UTF8)  # text() is UTF-8, as from ZXing 2.0 on
  # Not by their pkg-config files, which link libraries that are not used here: dlib's names some that its package does
  # not install. OMPL's sets an older C++, too.
  find_path(OMPL_INCLUDE_DIR ompl/geometric/PathSimplifier.h PATH_SUFFIXES ompl-1.5 ompl-1.6)
  find_library(OMPL_LIBRARY ompl)
  find_library(DLIB_LIBRARY dlib)
  find_library(BLAS_LIBRARY blas)  # for dlib's matrices
  musher_require_found(OMPL_INCLUDE_DIR libompl-dev)
  musher_require_found(OMPL_LIBRARY libompl-dev)
  musher_require_found(OCTOMAP_FOUND liboctomap-dev)
  musher_require_found(DLIB_LIBRARY libdlib-dev)
  musher_require_found(BLAS_LIBRARY libblas-dev)
  # The motion board's messages: lcm-gen makes their types, which need a header of LCM but not its library.
  find_path(LCM_INCLUDE_DIR lcm/lcm_coretypes.h)
  find_program(LCM_GEN lcm-gen)
  musher_require_found(LCM_INCLUDE_DIR liblcm-dev)
  musher_require_found(LCM_GEN liblcm-bin)
endif()

if(MUSHER_TESTS)
  musher_dependency(GTest libgtest-dev)
  musher_dependency(benchmark libbenchmark-dev)
  musher_dependency(rapidcheck librapidcheck-dev)
  if(MUSHER_MODULES)
    find_library(LCM_LIBRARY lcm)  # a motion board of tests is written with it
    musher_require_found(LCM_LIBRARY liblcm-dev)
  endif()
endif()
