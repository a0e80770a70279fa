// What Mesa and LLVM keep until the process ends is not ours to free.
// LeakSanitizer calls this by its reserved name.
extern "C" const char* __lsan_default_suppressions();   // NOLINT(readability-identifier-naming)
extern "C" const char* __lsan_default_suppressions() {  // NOLINT(readability-identifier-naming)
    return "leak:swrast_dri.so\nleak:libEGL_mesa.so\nleak:libgallium\nleak:libLLVM\nleak:libglapi\n";
}
