!> Results of the original program as records: the port fills them, the writers read them.
!>
!> All numbers are doubles. They hold the numbers of the shorter arithmetics exactly; those of
!> `real128` are rounded once.
module asperity_original_records
  use asperity_decimal, only: decimal_value
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: problem_list
  implicit none
  private

  public :: contact_record, model_record, original_records, original_request, position_record
  public :: append_contact, total_load_row, total_area_row, points_row, approach_row, slope_row
  public :: total_difference_row, individual_difference_row, original_positions, &
            thesis_tables

  !> Relative positions the original computes.
  integer, parameter :: original_positions = 100
  !> Positions whose contact tables the thesis prints.
  integer, parameter :: thesis_tables(3) = [13, 55, 56]

  ! Rows of Table VI.
  integer, parameter :: total_load_row = 1             !! N
  integer, parameter :: total_area_row = 2             !! cm2
  integer, parameter :: points_row = 3                 !! number of contacts
  integer, parameter :: approach_row = 4               !! cm
  integer, parameter :: slope_row = 5                  !! slope of contact areas
  integer, parameter :: total_difference_row = 6       !! calculated less projected total area, %
  integer, parameter :: individual_difference_row = 7  !! the same of individual areas, %

  !> Table V and Table III of one model, in cm, N and rad.
  type :: model_record
    integer :: number = 0                         !! asperities
    real(real64) :: radius = 0.0_real64           !! summit radius, cm
    real(real64) :: height_max = 0.0_real64       !! stated greatest height, cm
    real(real64) :: elastic_modulus = 0.0_real64  !! N/cm2
    real(real64) :: poisson_ratio = 0.0_real64    !! Poisson's ratio
    real(real64) :: stress_max = 0.0_real64       !! allowed stress, N/cm2
    real(real64) :: angle = 0.0_real64            !! rad
    real(real64), allocatable :: x(:)             !! mold positions, cm
    real(real64), allocatable :: y(:)             !! mold positions, cm, not mirrored
    real(real64), allocatable :: height(:)        !! heights, cm
  end type model_record

  !> One contact at one approach of one position.
  type :: contact_record
    integer :: position = 0                         !! 1 to 100
    integer :: step = 0                             !! approach number at the position, from 1
    integer :: area_no = 0                          !! number of the contact at this approach
    integer :: upper = 0                            !! index of the upper asperity
    integer :: lower = 0                            !! index of the lower asperity
    logical :: loaded = .false.                     !! false: touches without load
    logical :: limit_exceeded = .false.             !! load at or over WLIMIT
    real(real64) :: approach = 0.0_real64           !! cm
    real(real64) :: x = 0.0_real64                  !! centre of the contact, cm
    real(real64) :: y = 0.0_real64                  !! centre of the contact, cm
    real(real64) :: area = 0.0_real64               !! cm2
    real(real64) :: projected_area = 0.0_real64     !! cm2
    real(real64) :: slope = 0.0_real64              !! tangent of the contact's inclination
    real(real64) :: load = 0.0_real64               !! normal to the contact, N
    real(real64) :: average_pressure = 0.0_real64   !! N/cm2
    real(real64) :: maximum_pressure = 0.0_real64   !! N/cm2
  end type contact_record

  !> The last approach of one position, and its row of totals.
  type :: position_record
    real(real64) :: x_displacement = 0.0_real64  !! cm
    real(real64) :: y_displacement = 0.0_real64  !! cm
    real(real64) :: approach = 0.0_real64        !! cm
    real(real64) :: load = 0.0_real64            !! N
    real(real64) :: area = 0.0_real64            !! cm2
    real(real64) :: projected_area = 0.0_real64  !! cm2
    integer :: steps = 0                         !! approaches taken
    integer :: contacts = 0                      !! contacts at the last approach
    logical :: limit_reached = .false.           !! a contact reached WLIMIT
    integer :: first_contact = 1                 !! its rows in `contacts` are first_contact ...
    integer :: last_contact = 0                  !! ... to last_contact; none when not recorded
    real(real64), allocatable :: totals(:, :)    !! area, projected area, load; an approach a column
  end type position_record

  !> The choices of a run: rows that are kept, and the steps.
  type :: original_request
    logical :: keep_contacts(original_positions) = .false.  !! rows of these positions
    type(decimal_value) :: approach_step = decimal_value(1_int64, -3)  !! largest decrement, cm
    integer :: napmx = 25                                   !! approaches a position, at most
  end type original_request

  !> All that a run gives.
  type :: original_records
    character(len=4) :: word_no = ''                      !! printed for: within the limit
    character(len=4) :: word_yes = ''                     !! printed for: limit exceeded
    type(model_record) :: upper                           !! upper model
    type(model_record) :: lower                           !! lower model
    type(contact_record), allocatable :: contacts(:)      !! rows kept, in the order computed
    integer :: contacts_used = 0                          !! rows in use
    type(position_record) :: positions(original_positions)  !! every position
    real(real64) :: variance(7, 3) = 0.0_real64           !! Table VI: maximum, minimum, average
    type(problem_list) :: notes                           !! faults that came to bear
    integer :: last_heading = 0                           !! last position that prints its headings
    logical :: is_complete = .false.                      !! all sections have ended
  end type original_records

contains

  !> Adds a row to those kept.
  subroutine append_contact(records, contact)
    type(original_records), intent(inout) :: records  !! records of the run, one row longer after
                                                      !! the call
    type(contact_record), intent(in) :: contact       !! row that is added
    type(contact_record), allocatable :: larger(:)

    if (.not. allocated(records%contacts)) allocate (records%contacts(256))
    if (records%contacts_used == size(records%contacts)) then
      allocate (larger(2 * size(records%contacts)))
      larger(:records%contacts_used) = records%contacts
      call move_alloc(larger, records%contacts)
    end if
    records%contacts_used = records%contacts_used + 1
    records%contacts(records%contacts_used) = contact
  end subroutine append_contact

end module asperity_original_records
