#include "client/render/gl_context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl3.h>

#include <array>
#include <cstring>
#include <string_view>
#include <vector>

#include "client/render/rasterizer_threads.h"

namespace lodestream::render {
namespace {

constexpr EGLint max_devices = 16;

bool has_word(const char* words, std::string_view word) {
    std::string_view rest = words ? words : "";
    while (!rest.empty()) {
        const std::size_t end = std::min(rest.find(' '), rest.size());
        if (rest.substr(0, end) == word) return true;
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return false;
}

template <class Function>
Function egl_function(const char* name) {
    return reinterpret_cast<Function>(eglGetProcAddress(name));
}

// GPUs first, in the driver's order; devices that draw in software are left to the surfaceless platform.
std::vector<EGLDisplay> gpu_displays() {
    const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (!has_word(extensions, "EGL_EXT_platform_device")) return {};
    const auto query_devices = egl_function<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    const auto device_string = egl_function<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
    const auto platform_display = egl_function<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    std::array<EGLDeviceEXT, max_devices> devices{};
    EGLint count = 0;
    if (!query_devices || !device_string || !platform_display || !query_devices(max_devices, devices.data(), &count))
        return {};
    std::vector<EGLDisplay> displays;
    for (EGLint i = 0; i < count; ++i) {
        const auto device = devices[static_cast<std::size_t>(i)];
        if (has_word(device_string(device, EGL_EXTENSIONS), "EGL_MESA_device_software")) continue;
        displays.push_back(platform_display(EGL_PLATFORM_DEVICE_EXT, device, nullptr));
    }
    return displays;
}

EGLDisplay surfaceless_display() {
    if (!has_word(eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), "EGL_MESA_platform_surfaceless"))
        return EGL_NO_DISPLAY;
    const auto platform_display = egl_function<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    if (!platform_display) return EGL_NO_DISPLAY;
    return platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
}

std::string gl_string(GLenum name) {
    const GLubyte* text = glGetString(name);
    return text ? reinterpret_cast<const char*>(text) : "";
}

}  // namespace

struct GlContext::Impl {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;
    std::string renderer;
    std::string version;

    Impl() = default;
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    bool make_current() const { return eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_TRUE; }

    bool open(EGLDisplay candidate) {
        if (candidate == EGL_NO_DISPLAY || !eglInitialize(candidate, nullptr, nullptr)) return false;
        display = candidate;
        if (!has_word(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context")) return false;
        if (!eglBindAPI(EGL_OPENGL_ES_API)) return false;
        const std::array<EGLint, 5> config_attributes{EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_SURFACE_TYPE, 0,
                                                      EGL_NONE};
        EGLConfig config = nullptr;
        EGLint configs = 0;
        if (!eglChooseConfig(display, config_attributes.data(), &config, 1, &configs) || configs < 1) return false;
        const std::array<EGLint, 3> context_attributes{EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
        context = eglCreateContext(display, config, EGL_NO_CONTEXT, context_attributes.data());
        if (context == EGL_NO_CONTEXT || !make_current()) return false;
        renderer = gl_string(GL_RENDERER);
        version = gl_string(GL_VERSION);
        return true;
    }

    // The display stays initialised: it is shared by every context of the process on it.
    ~Impl() {
        if (context == EGL_NO_CONTEXT) return;
        if (eglGetCurrentContext() == context) eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        eglDestroyContext(display, context);
    }
};

GlContext::GlContext(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GlContext::GlContext(GlContext&&) noexcept = default;
GlContext& GlContext::operator=(GlContext&&) noexcept = default;
GlContext::~GlContext() = default;

void GlContext::make_current() {
    impl_->make_current();
}
const std::string& GlContext::renderer() const {
    return impl_->renderer;
}
const std::string& GlContext::version() const {
    return impl_->version;
}

bool GlContext::software() const {
    for (const char* name : {"llvmpipe", "softpipe", "SwiftShader", "swrast"})
        if (impl_->renderer.find(name) != std::string::npos) return true;
    return false;
}

Result<GlContext> create_headless_context() {
    std::vector<EGLDisplay> displays = gpu_displays();
    displays.push_back(surfaceless_display());
    for (EGLDisplay display : displays) {
        auto impl = std::make_unique<GlContext::Impl>();
        if (!impl->open(display)) continue;
        GlContext context(std::move(impl));
        if (context.software()) spread_rasterizer_threads();
        return context;
    }
    return fail(ErrorCode::unavailable,
                "no EGL driver offers OpenGL ES 3 without a display (libegl-mesa0, libgl1-mesa-dri)");
}

}  // namespace lodestream::render
