// A stand-in for the driver of an NVIDIA GPU and for NVRTC, on machines without them: "machine code" is a library of the host that
// g++ makes of a kernel's text, and the host runs the threads of a launch one after another, before the launch returns. The
// functions have the types of CUDA's. COMPILER is the command of g++ with the folder of cuda_shim.h.
#include <dlfcn.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace {
// The kernel's threads, for the text of a kernel `modyn_rows`.
const char *const LAUNCH = R"(
#include <utility>
template <class... A, std::size_t... I>
static void run(void (*kernel)(A...), unsigned blocks, unsigned threads, void **arguments, std::index_sequence<I...>)
{
    blockDim.x = threads;
    for (blockIdx.x = 0; blockIdx.x < blocks; ++blockIdx.x)
        for (threadIdx.x = 0; threadIdx.x < threads; ++threadIdx.x) kernel(*static_cast<A *>(arguments[I])...);
}
template <class... A> static void run(void (*kernel)(A...), unsigned blocks, unsigned threads, void **arguments)
{
    run(kernel, blocks, threads, arguments, std::index_sequence_for<A...>{});
}
extern "C" void launch(unsigned blocks, unsigned threads, void **arguments) { run(modyn_rows, blocks, threads, arguments); }
)";

struct Program {
    std::string text, log, code;
};

std::string bytes_of(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::string folder()
{
    char name[] = "/tmp/modyn-stand-in-XXXXXX";
    return mkdtemp(name);
}

int context, contexts;
}

// What tests read.
extern "C" {
long launches, compilations, libraries;
void *last_stream;
int last_context = -1;

// The driver.
int cuInit(unsigned) { return 0; }
int cuDriverGetVersion(int *version) { return *version = 13000, 0; }
int cuGetErrorString(int error, const char **text)
{
    *text = error == 1 ? "invalid argument" : error == 101 ? "invalid device ordinal" : "invalid context";
    return 0;
}
int cuDeviceGet(int *device, int ordinal)
{
    if (ordinal != 0) return 101;
    return *device = 0, 0;
}
int cuDeviceGetAttribute(int *value, int attribute, int) { return *value = attribute == 75 ? 9 : 0, 0; }
int cuDevicePrimaryCtxRetain(void **result, int) { return *result = &context, 0; }
int cuCtxPushCurrent_v2(void *given)
{
    if (given != &context) return 201;
    return ++contexts, 0;
}
int cuCtxPopCurrent_v2(void **result) { return *result = &context, --contexts < 0 ? 201 : 0; }

int cuLibraryLoadData(void **library, const void *code, void *, void **, unsigned, void *, void **, unsigned)
{
    // The length of the code is before it, as that of an ELF file is in its header.
    size_t length;
    std::memcpy(&length, code, sizeof length);
    const std::string at = folder(), path = at + "/kernel.so";
    std::ofstream(path, std::ios::binary).write(static_cast<const char *>(code) + sizeof length, length);
    *library = dlopen(path.c_str(), RTLD_NOW);
    unlink(path.c_str());
    rmdir(at.c_str());
    return ++libraries, *library ? 0 : 1;
}
int cuLibraryGetKernel(void **kernel, void *library, const char *name)
{
    if (!dlsym(library, name)) return 1;
    return *kernel = dlsym(library, "launch"), *kernel ? 0 : 1;
}
int cuLaunchKernel(void *kernel, unsigned x, unsigned y, unsigned z, unsigned threads, unsigned, unsigned, unsigned, void *stream,
                   void **arguments, void **)
{
    if (x == 0 || y != 1 || z != 1 || threads == 0 || threads > 128) return 1;
    // The context is that of a stream; without a stream it is the current one.
    last_stream = stream;
    last_context = contexts;
    ++launches;
    reinterpret_cast<void (*)(unsigned, unsigned, void **)>(kernel)(x, threads, arguments);
    return 0;
}

// NVRTC.
int nvrtcVersion(int *major, int *minor) { return *major = 13, *minor = 0; }
int nvrtcCreateProgram(Program **program, const char *text, const char *, int, const char **, const char **)
{
    *program = new Program{text, {}, {}};
    return 0;
}
int nvrtcCompileProgram(Program *program, int count, const char **options)
{
    ++compilations;
    if (count == 0 || std::strcmp(options[0], "--gpu-architecture=sm_90") != 0) return 5;
    const std::string at = folder(), text = at + "/kernel.cpp", library = at + "/kernel.so", log = at + "/log";
    std::ofstream(text) << "#include <cstddef>\n#include \"cuda_shim.h\"\n" << program->text << LAUNCH;
    const int failed = std::system((COMPILER " -std=c++17 -O0 -w -shared -fPIC -o " + library + " " + text + " 2> " + log).c_str());
    program->log = bytes_of(log);
    const std::string code = bytes_of(library);
    const size_t length = code.size();
    program->code = std::string(reinterpret_cast<const char *>(&length), sizeof length) + code;
    std::system(("rm -r " + at).c_str());
    return failed ? 6 : 0;
}
int nvrtcGetProgramLogSize(Program *program, size_t *size) { return *size = program->log.size() + 1, 0; }
int nvrtcGetProgramLog(Program *program, char *log) { return std::memcpy(log, program->log.c_str(), program->log.size() + 1), 0; }
int nvrtcGetCUBINSize(Program *program, size_t *size) { return *size = program->code.size(), 0; }
int nvrtcGetCUBIN(Program *program, char *code) { return std::memcpy(code, program->code.data(), program->code.size()), 0; }
int nvrtcDestroyProgram(Program **program) { return delete *program, *program = nullptr, 0; }
}
