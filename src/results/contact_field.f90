!> Pressure and gap in one state, on the pixels of a height map or on the cells of a grid.
module asperity_contact_field
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_problems, only: decimal_text
  implicit none
  private

  public :: contact_field, contact_marks, room_of_fields
  public :: fields_none, fields_last, fields_all
  public :: parts_in_words, pressure_histogram

  !> Which states keep their fields: none, the last of the path, all.
  integer, parameter :: fields_none = 0, fields_last = 1, fields_all = 2

  !> The fields of one state, by column and row of the map or grid. A pixel that was not measured,
  !> or has no surface, has `not_computed` in all three.
  type :: contact_field
    integer :: position = 1                          !! number of the position, from 1
    integer :: state = 1                             !! number of the state in its position, from 1
    integer :: columns = 0                           !! pixels along x
    integer :: rows = 0                              !! pixels along y
    real(real64) :: pixel_spacing(2) = 0.0_real64    !! of the pixels along x and y [length]
    logical :: periodic = .false.                    !! the pixels repeat in both directions
    integer :: strip_axis = 0                        !! axis along which alone they do; 0: none
    character(len=:), allocatable :: unit            !! unit of length; empty: not known
    real(real64) :: origin(2) = 0.0_real64           !! centre of the first pixel in plan [length]
    !> Contacts whose pressure on a grid is that of boundary elements, and of Hertz; less than 0:
    !> the pixels are those of a height map.
    integer :: boundary_contacts = -1, hertz_contacts = -1
    real(real64) :: level = 0.0_real64               !! height of the flat above the mean plane
    !> More than 0 in contact, 0 elsewhere; with adhesion the net traction, also below 0.
    real(real64), allocatable :: pressure(:, :)
    !> Local distance of the deformed surfaces, `level` - height + displacement: 0 in contact,
    !> elsewhere 0 or more.
    real(real64), allocatable :: gap(:, :)
    !> Sum of the elastic displacements of both surfaces, > 0 apart from each other: on a free map
    !> that of a half-space without load elsewhere; on a periodic map its mean is 0.
    real(real64), allocatable :: displacement(:, :)
    !> Tangential traction on the lower body along x and y, slip of the upper body over it, and
    !> whether a pixel sticks; not allocated: no tangential load.
    real(real64), allocatable, dimension(:, :) :: traction, traction_y, slip_x, slip_y
    logical, allocatable :: sticks(:, :)
  end type contact_field

contains

  !> Sources of the pressure on a grid; empty for the pixels of a map.
  pure function parts_in_words(field) result(text)
    type(contact_field), intent(in) :: field  !! fields of one state
    character(len=:), allocatable :: text     !! text of one line

    text = ''
    if (field%hertz_contacts < 0) return
    text = decimal_text(field%boundary_contacts) // ' from boundary elements, ' // &
           decimal_text(field%hertz_contacts) // ' from Hertz'' law'
  end function parts_in_words

  !> Whether each pixel is in contact: under pressure, or under tension without a gap.
  pure function contact_marks(field) result(marks)
    type(contact_field), intent(in) :: field  !! fields of one state
    logical, allocatable :: marks(:, :)

    marks = field%pressure > 0.0_real64 .or. &
            (field%pressure < 0.0_real64 .and. .not. abs(field%gap) > 0.0_real64)
  end function contact_marks

  !> Memory of the fields of some states, bytes.
  pure integer(int64) function room_of_fields(pixels, states) result(bytes)
    integer(int64), intent(in) :: pixels  !! pixels of the map
    integer, intent(in) :: states         !! number of states kept

    bytes = 24_int64 * pixels * states
  end function room_of_fields

  !> Distribution of the pressure in contact: bins of equal width between 0 and the greatest
  !> pressure. The density is area per pressure over the measured area. Its integral, the sum times
  !> the width, is the contact area fraction of the pixels. Without contact all bins are empty.
  pure subroutine pressure_histogram(field, centre, density)
    type(contact_field), intent(in) :: field   !! fields of one state
    real(real64), intent(out) :: centre(:)     !! pressure in the middle of each bin
    real(real64), intent(out) :: density(:)    !! density of each bin, 1/pressure
    real(real64) :: width
    integer(int64) :: measured
    integer :: bin, i, j

    width = maxval([0.0_real64, maxval(field%pressure)]) / size(centre)
    centre = [((bin - 0.5_real64) * width, bin=1, size(centre))]
    density = 0.0_real64
    if (.not. width > 0.0_real64) return
    do j = 1, size(field%pressure, 2)
      do i = 1, size(field%pressure, 1)
        if (.not. field%pressure(i, j) > 0.0_real64) cycle
        bin = min(size(density), 1 + int(field%pressure(i, j) / width))
        density(bin) = density(bin) + 1.0_real64
      end do
    end do
    measured = count(field%pressure > not_computed, kind=int64)
    density = density / (measured * width)
  end subroutine pressure_histogram

end module asperity_contact_field
