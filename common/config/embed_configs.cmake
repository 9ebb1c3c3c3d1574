# cmake -DOUTPUT=builtin.cc -DROOT=configs -DNAMES=a.yaml,b.yaml -P embed_configs.cmake
# Writes the files as raw string literals, so that the programs run without the configs folder.
string(REPLACE "," ";" names "${NAMES}")
set(entries "")
foreach(name ${names})
  file(READ ${ROOT}/${name} text)
  string(APPEND entries "    {\"${name}\", R\"__yaml__(${text})__yaml__\"},\n")
endforeach()
file(WRITE ${OUTPUT} "// Generated from configs/.
#include \"common/config/builtin.h\"

namespace parallax::config_internal {

std::span<const BuiltinFile> BuiltinFiles() {
  static constexpr BuiltinFile kFiles[] = {
${entries}  };
  return kFiles;
}

}  // namespace parallax::config_internal
")
