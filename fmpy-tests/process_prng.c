/* bcryptprimitives.dll for wine 8 and older, which lack it: Rust's standard library asks it for the seed of a hash map. Windows has it. */

#include <windows.h>

BOOLEAN NTAPI SystemFunction036(PVOID, ULONG); /* RtlGenRandom */

__declspec(dllexport) BOOL ProcessPrng(BYTE *data, SIZE_T size) { return SystemFunction036(data, (ULONG)size); }
