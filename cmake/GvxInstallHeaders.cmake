# Run by `cmake --install`: installs GVX_PUBLIC_HEADERS, which are told from GVX_HEADERS_FROM, and all headers that
# they include, into the folder gvx of GVX_HEADERS_TO, a folder of the prefix.

cmake_policy(VERSION 3.25)  # an install's script has none
set(waiting ${GVX_PUBLIC_HEADERS})
set(headers)
while(waiting)
  list(POP_FRONT waiting header)
  if(header IN_LIST headers)
    continue()
  endif()
  list(APPEND headers ${header})
  file(STRINGS ${GVX_HEADERS_FROM}/${header} includes REGEX "^[ ]*#[ ]*include \"gvx/")
  list(TRANSFORM includes REPLACE ".*\"gvx/([^\"]+)\".*" "\\1")
  list(APPEND waiting ${includes})
endwhile()
cmake_path(ABSOLUTE_PATH GVX_HEADERS_TO BASE_DIRECTORY ${CMAKE_INSTALL_PREFIX})
foreach(header ${headers})
  cmake_path(GET header PARENT_PATH room)
  file(INSTALL DESTINATION ${GVX_HEADERS_TO}/gvx/${room} TYPE FILE
    FILES ${GVX_HEADERS_FROM}/${header})
endforeach()
