# find_package(heft): heft::heft is the shared library, or the static one where there is no other; heft::static.
get_filename_component(_heft_lib "${CMAKE_CURRENT_LIST_DIR}/../.." ABSOLUTE)
# In a folder of its own the header is one level up, below /usr/lib/ARCHITECTURE two.
find_path(_heft_include heft.h PATHS "${_heft_lib}/../include" "${_heft_lib}/../../include" NO_DEFAULT_PATH NO_CACHE)

if(NOT TARGET heft::static)
  add_library(heft::static STATIC IMPORTED)
  set_target_properties(heft::static PROPERTIES
    IMPORTED_LOCATION "${_heft_lib}/libheft.a"
    INTERFACE_INCLUDE_DIRECTORIES "${_heft_include}"
    INTERFACE_LINK_LIBRARIES "m;pthread;dl")
endif()
if(NOT TARGET heft::heft)
  if(EXISTS "${_heft_lib}/libheft.so")
    get_filename_component(_heft_shared "${_heft_lib}/libheft.so" REALPATH)
    add_library(heft::heft SHARED IMPORTED)
    set_target_properties(heft::heft PROPERTIES
      IMPORTED_LOCATION "${_heft_shared}"
      INTERFACE_INCLUDE_DIRECTORIES "${_heft_include}")
  else()
    add_library(heft::heft INTERFACE IMPORTED)
    set_target_properties(heft::heft PROPERTIES INTERFACE_LINK_LIBRARIES heft::static)
  endif()
endif()
