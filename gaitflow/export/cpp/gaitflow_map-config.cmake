# The map for CMake: its C functions as a static library, its headers, C++17.
#
#     find_package(gaitflow_map REQUIRED)                    # cmake -Dgaitflow_map_DIR=<this folder>
#     target_link_libraries(my_planner gaitflow_map)
#
# The project has to have the languages C and CXX.
if(TARGET gaitflow_map)
  return()
endif()
add_library(gaitflow_map STATIC
  "${CMAKE_CURRENT_LIST_DIR}/problem.c"
  "${CMAKE_CURRENT_LIST_DIR}/jacobian.c"
  "${CMAKE_CURRENT_LIST_DIR}/hessian.c")
target_include_directories(gaitflow_map PUBLIC "${CMAKE_CURRENT_LIST_DIR}")
target_compile_features(gaitflow_map PUBLIC cxx_std_17)
# A longer build than with -O1, for a third less time in the problem's functions. A level in CMAKE_C_FLAGS stays.
if(NOT CMAKE_C_FLAGS MATCHES "-O")
  target_compile_options(gaitflow_map PRIVATE -O3)
endif()
target_link_libraries(gaitflow_map PUBLIC m)
