/* Dynamics of a robot, compiled by modyn: C++17 over @STEM@.h, with Eigen 3.3 or later. */
#ifndef @UPPER@_HPP
#define @UPPER@_HPP

#include <array>
#include <cstddef>
#include <cstring>

#include <Eigen/Core>

#include "@STEM@.h"

/// The dynamics of the robot. SI units, radians. Gravity is by default @GRAVITY@ m/s^2 in world axes.
///
/// Vectors are in the order of the description's joints, depth first. Quaternions are x, y, z, w. Twists, the
/// columns of Jacobians and the velocity of a floating joint are linear, then angular; wrenches are the force, then
/// the moment. The velocity of a floating joint is in the axes of its link. No function allocates memory or throws.
class @CLASS@ {
public:
    using Scalar = @REAL@;
    /// The number of coordinates.
    static constexpr int nq = @UPPER@_NQ;
    /// The number of velocities: the degrees of freedom.
    static constexpr int nv = @UPPER@_NV;
    /// The number of links.
    static constexpr int links = @UPPER@_LINKS;

    template <int Rows, int Cols>
    using Matrix = Eigen::Matrix<Scalar, Rows, Cols,
                                 Eigen::DontAlign | (Rows == 1 && Cols != 1 ? Eigen::RowMajor : Eigen::ColMajor)>;
    template <int Size>
    using Vector = Matrix<Size, 1>;
    /// A matrix by rows.
    template <int Rows, int Cols>
    using RowMatrix = Eigen::Matrix<Scalar, Rows, Cols, Eigen::DontAlign | Eigen::RowMajor>;
    using Rotation = Eigen::Matrix<Scalar, 3, 3, Eigen::DontAlign | Eigen::RowMajor>;
    /// An argument: a vector, a map, a segment or an expression of this size.
    template <int Size>
    using VectorRef = Eigen::Ref<const Vector<Size>>;
    template <int Rows, int Cols>
    using MatrixRef = Eigen::Ref<const Matrix<Rows, Cols>, 0, Eigen::Stride<0, 0>>;
    /// Any number of columns: of a matrix whose number of rows is known at compile time, else they are copied.
    template <int Rows>
    using Columns = Eigen::Ref<const Matrix<Rows, Eigen::Dynamic>, 0, Eigen::OuterStride<Rows>>;

@MEMBERS@private:
    template <std::size_t Size>
    static Vector<static_cast<int>(Size)> numbers(const std::array<bool, Size> &set) noexcept {
        Vector<static_cast<int>(Size)> result;
        for (std::size_t i = 0; i < Size; ++i) result[static_cast<int>(i)] = set[i] ? Scalar(1) : Scalar(0);
        return result;
    }
};

#endif
