/* The part of <math.h> that generated C needs, for targets without a C library: the compiler has it built in. */
#define INFINITY __builtin_inff()
#define NAN __builtin_nanf("")
float fabsf(float x);
float sqrtf(float x);
double fabs(double x);
double sqrt(double x);
