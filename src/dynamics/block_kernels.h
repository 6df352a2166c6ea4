#pragma once

namespace clothsim {

// A block of 3 x 3 numbers is three columns of four, the last number 0: 12 in all. Vectors have
// four numbers a row, the last 0.
enum { block_size = 12 };

/// product = A vector in rows [begin, end), which nothing joins to others, for a symmetric A. The
/// columns of row a have blocks firsts[a] up to firsts[a + 1], in the rows ends[block]: first the
/// row's own, then those of later rows.
void multiply(int begin, int end, const int* firsts, const int* ends, const double* blocks,
              const double* vector, double* product);

/// product = A vector in rows [begin, end), for an A with one block for each row.
void multiply_points(int begin, int end, const double* blocks, const double* vector,
                     double* product);

}  // namespace clothsim
